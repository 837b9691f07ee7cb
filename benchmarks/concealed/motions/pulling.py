"""Motions of a level sheet between two clamps, as in a tensile tester: pull, shear, hammock, wave.

Level, so that its weight decides to which side it bows and wrinkles: an upright sheet could do either.
"""

import numpy as np

from benchmarks.concealed.cloth import Cloth
from benchmarks.concealed.motions.motion import MOVES_AT_S, Block, Motion, bars, course_of
from benchmarks.concealed.motions.paths import rise, there_and_back, wave

FRONT, BACK = 0, 1
ALONG, AWAY, UP = 0, 1, 2
LEVEL = np.eye(3)
"""Rest mesh axes (u, v, normal) are the world's: row 0 in front."""
HEIGHT_M = 0.8
TAUT = 0.003
"""Strain along the sheet at rest: it sags by about a centimetre under its weight."""


def taut_load_n(cloth: Cloth, rows: int) -> float:
    """Pull of a clamp at rest: what TAUT asks of the free rows, and what a shallow arc under its own weight adds.

    T / (E w) = strain + (W / T)^2 / 24, a heavy string of small sag.
    """
    free = 1 - 2 / (rows - 1)
    stiffness, weight = cloth.stretch_n_m * cloth.size_u_m, cloth.weight_n * free
    roots = np.roots([1 / stiffness, -TAUT / free, 0.0, -(weight**2) / 24])
    return float(roots.real[np.abs(roots.imag) < 1e-9].max())


def _level(name: str, cloth: Cloth, blocks: tuple[Block, ...], parts) -> Motion:
    origin = np.array([-cloth.size_u_m / 2, -cloth.size_v_m / 2, HEIGHT_M])
    return Motion(name, False, blocks, LEVEL, origin, course_of(2, parts))


def bars_pull(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The back clamp pulls the sheet longer by some percent, twice, and gives way in between."""
    strain = 0.025 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        pull = there_and_back(t, MOVES_AT_S, 0.6, 0.2) + 1.2 * there_and_back(t, 2.1, 0.6, 0.3)
        shift[:, BACK, AWAY] += cloth.size_v_m * (TAUT + strain * pull)

    return _level("bars_pull", cloth, bars(columns, rows), parts)


def bars_shear(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The back clamp goes to and fro along its length while the sheet is kept taut."""
    shear = 0.05 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        shift[:, BACK, AWAY] += cloth.size_v_m * (TAUT + 0.012 * rise(t, MOVES_AT_S, 0.6))
        shift[:, BACK, ALONG] += cloth.size_v_m * shear * wave(t, 1.0, 3.6, 0.55)

    return _level("bars_shear", cloth, bars(columns, rows), parts)


def bars_slant(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The back clamp goes aside along its length, stays there while it pulls, and goes to the other side."""
    aside, strain = 0.045 * rng.uniform(0.85, 1.15), 0.016 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        pull = rise(t, MOVES_AT_S, 0.6) + there_and_back(t, 1.9, 0.6, 0.3)
        shift[:, BACK, AWAY] += cloth.size_v_m * (TAUT + strain * pull)
        shift[:, BACK, ALONG] += cloth.size_v_m * aside * (rise(t, 0.9, 0.9) - 1.5 * rise(t, 3.0, 0.8))

    return _level("bars_slant", cloth, bars(columns, rows), parts)


def centre_pull(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A small gripper in the middle of the back edge pulls, then sideways: a strain that differs from place to place."""
    pull, aside = 0.045 * rng.uniform(0.85, 1.15), 0.04 * rng.uniform(0.85, 1.15)
    middle = (columns - 1) // 2
    blocks = (Block("front", (0, 1), (0, columns - 1)), Block("back", (rows - 2, rows - 1), (middle - 2, middle + 2)))

    def parts(t, shift, turn):
        away = 0.3 * rise(t, MOVES_AT_S, 0.5) + 0.7 * there_and_back(t, 1.2, 0.6, 0.8)
        shift[:, BACK, AWAY] += cloth.size_v_m * (TAUT + pull * away)
        shift[:, BACK, ALONG] += cloth.size_v_m * aside * wave(t, 2.0, 3.8, 0.6)

    return _level("centre_pull", cloth, blocks, parts)


def bars_squeeze(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The back clamp comes nearer and the sheet hangs in a deeper arc, more and less."""
    near = 0.2 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        shift[:, BACK, AWAY] -= cloth.size_v_m * (0.08 + near * there_and_back(t, MOVES_AT_S, 1.1, 0.3))
        turn[:, FRONT, ALONG] -= 0.5
        turn[:, BACK, ALONG] += 0.5

    return _level("bars_squeeze", cloth, bars(columns, rows), parts)


def bars_wave(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A sheet that hangs in an arc between clamps; the back one goes up and down, then to and fro along itself."""
    amplitude, rate = 0.04 * rng.uniform(0.85, 1.15), rng.uniform(0.6, 0.8)

    def parts(t, shift, turn):
        shift[:, BACK, AWAY] -= cloth.size_v_m * 0.08
        shift[:, BACK, UP] += amplitude * wave(t, MOVES_AT_S, 2.6, rate)
        shift[:, BACK, ALONG] += 0.5 * amplitude * wave(t, 2.0, 3.7, rate)
        turn[:, FRONT, ALONG] -= 0.5
        turn[:, BACK, ALONG] += 0.5

    return _level("bars_wave", cloth, bars(columns, rows), parts)


MOTIONS = {make.__name__: make for make in (bars_pull, bars_slant, centre_pull, bars_shear, bars_squeeze, bars_wave)}
