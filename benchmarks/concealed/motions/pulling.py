"""Motions of a sheet between two clamps, as in a tensile tester: pull, shear, squeeze into an arc, wave."""

import numpy as np

from benchmarks.concealed.cloth import Cloth
from benchmarks.concealed.motions.motion import HANGING, MOVES_AT_S, Block, Motion, bars, course_of, hanging_origin
from benchmarks.concealed.motions.paths import rise, there_and_back, wave

TOP, BOTTOM = 0, 1
ALONG, OUT, UP = 0, 1, 2


def _between_bars(name: str, cloth: Cloth, columns: int, rows: int, parts) -> Motion:
    return Motion(name, False, bars(columns, rows), HANGING, hanging_origin(cloth), course_of(2, parts))


def _taut_m(cloth: Cloth) -> float:
    """Half as much again as the sheet's own weight stretches it, so that no part of it is slack at rest."""
    return 1.5 * cloth.area_density_kg_m2 * 9.81 * cloth.size_v_m**2 / (2 * cloth.stretch_n_m)


def bars_pull(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The lower clamp pulls the sheet longer by some percent, twice, and gives way in between."""
    strain = 0.025 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        pull = there_and_back(t, MOVES_AT_S, 0.6, 0.2) + 1.2 * there_and_back(t, 2.1, 0.6, 0.3)
        shift[:, BOTTOM, UP] -= _taut_m(cloth) + cloth.size_v_m * strain * pull

    return _between_bars("bars_pull", cloth, columns, rows, parts)


def bars_shear(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The lower clamp goes to and fro along its length while the sheet is kept taut."""
    shear = 0.05 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        shift[:, BOTTOM, UP] -= _taut_m(cloth) + cloth.size_v_m * 0.018 * rise(t, MOVES_AT_S, 0.6)
        shift[:, BOTTOM, ALONG] += cloth.size_v_m * shear * wave(t, 1.0, 3.6, 0.55)

    return _between_bars("bars_shear", cloth, columns, rows, parts)


def bars_squeeze(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The lower clamp comes up and the sheet bows out to one side, more and less."""
    near = 0.22 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        shift[:, BOTTOM, UP] += cloth.size_v_m * (0.15 + near * there_and_back(t, MOVES_AT_S, 1.1, 0.3))
        turn[:, TOP, ALONG] += 0.35
        turn[:, BOTTOM, ALONG] -= 0.35

    return _between_bars("bars_squeeze", cloth, columns, rows, parts)


def bars_wave(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A slack sheet between clamps whose lower one goes to and fro out of the plane."""
    amplitude, rate = 0.03 * rng.uniform(0.85, 1.15), rng.uniform(0.5, 0.7)

    def parts(t, shift, turn):
        shift[:, BOTTOM, UP] += cloth.size_v_m * 0.16
        shift[:, BOTTOM, OUT] += amplitude * wave(t, MOVES_AT_S, 3.4, rate)
        turn[:, TOP, ALONG] += 0.45
        turn[:, BOTTOM, ALONG] -= 0.45

    return _between_bars("bars_wave", cloth, columns, rows, parts)


def centre_pull(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A small gripper in the middle of the lower edge pulls down, then sideways: a strain that differs from place to place."""
    pull, aside = 0.045 * rng.uniform(0.85, 1.15), 0.04 * rng.uniform(0.85, 1.15)
    middle = (columns - 1) // 2
    blocks = (Block("top", (0, 1), (0, columns - 1)), Block("bottom", (rows - 2, rows - 1), (middle - 1, middle + 1)))

    def parts(t, shift, turn):
        down = 0.3 * rise(t, MOVES_AT_S, 0.5) + 0.7 * there_and_back(t, 1.2, 0.6, 0.8)
        shift[:, BOTTOM, UP] -= _taut_m(cloth) + cloth.size_v_m * pull * down
        shift[:, BOTTOM, ALONG] += cloth.size_v_m * aside * wave(t, 2.0, 3.8, 0.6)

    return Motion("centre_pull", False, blocks, HANGING, hanging_origin(cloth), course_of(2, parts))


MOTIONS = {make.__name__: make for make in (bars_pull, centre_pull, bars_shear, bars_squeeze, bars_wave)}
