"""Motions over a table: laying down, lifting off, dragging flat and with the edge raised."""

import numpy as np

from benchmarks.concealed.cloth import Cloth
from benchmarks.concealed.motions.motion import HANGING, MOVES_AT_S, Block, Motion, bar, corners, course_of
from benchmarks.concealed.motions.paths import rise, there_and_back, wave

ALONG, BEHIND, UP = 0, 1, 2
"""Axes of the flat sheet on the table: u is x, v is y. Row 0 is held; pulling goes to -y."""

FLAT = np.eye(3)
TABLE_M = 0.0


def _flat_origin(cloth: Cloth) -> np.ndarray:
    return np.array([-cloth.size_u_m / 2, 0.0, TABLE_M + cloth.thickness_m / 2])


def _on_table(name: str, cloth: Cloth, blocks, parts) -> Motion:
    return Motion(name, True, blocks, FLAT, _flat_origin(cloth), course_of(len(blocks), parts))


def trail(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A pin in the middle of the edge, at table height, goes along a bent way: the sheet follows as a trailer does."""
    way, aside = 0.15 * rng.uniform(0.85, 1.15), 0.10 * rng.uniform(0.85, 1.15)
    middle = (columns - 1) // 2

    def parts(t, shift, turn):
        shift[:, 0, BEHIND] -= way * rise(t, MOVES_AT_S, 3.0)
        shift[:, 0, ALONG] += aside * (rise(t, 0.9, 1.1) - 1.6 * rise(t, 2.2, 1.4))

    return _on_table("trail", cloth, (Block("pin", (0, 0), (middle, middle)),), parts)


def drag_raised(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """An edge is raised to a third of the sheet's length, turned down with it, and goes to and fro."""
    height, way = 0.36 * cloth.size_v_m * rng.uniform(0.9, 1.1), 0.07 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        up = rise(t, MOVES_AT_S, 1.0)
        shift[:, 0, UP] += height * up
        shift[:, 0, BEHIND] += 0.10 * cloth.size_v_m * up
        turn[:, 0, ALONG] -= 1.0 * up
        shift[:, 0, BEHIND] -= way * (there_and_back(t, 1.6, 0.6, 0.1) + rise(t, 3.0, 0.6))

    return _on_table("drag_raised", cloth, bar(columns, rows), parts)


def lift_off(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """An edge goes up in an arc until most of the sheet is off the table, and half way back."""
    share = 1.15 * rng.uniform(0.9, 1.05)

    def parts(t, shift, turn):
        theta = share * (rise(t, MOVES_AT_S, 1.5) - 0.5 * rise(t, 2.6, 1.0))
        shift[:, 0, UP] += cloth.size_v_m * np.sin(theta) * 0.95
        shift[:, 0, BEHIND] += cloth.size_v_m * (1 - np.cos(theta))
        turn[:, 0, ALONG] -= 0.9 * theta

    return _on_table("lift_off", cloth, bar(columns, rows), parts)


def peel(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """Two corners are lifted and moved over the sheet a little, sideways, and back."""
    height = 0.33 * cloth.size_v_m * rng.uniform(0.9, 1.1)

    def parts(t, shift, turn):
        up = there_and_back(t, MOVES_AT_S, 1.2, 0.7)
        shift[:, :, UP] += (height * up)[:, None]
        shift[:, :, BEHIND] += (0.18 * cloth.size_v_m * up)[:, None]
        turn[:, :, ALONG] -= (0.8 * up)[:, None]
        shift[:, :, ALONG] += (0.03 * wave(t, 1.4, 3.4, 0.6))[:, None]

    return _on_table("peel", cloth, corners(columns, rows), parts)


def lay_down(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A hanging sheet is laid down: the clamp goes down on a circle about the free edge and turns level."""
    down = 1.36 * rng.uniform(0.95, 1.0)
    origin = np.array([-cloth.size_u_m / 2, 0.0, TABLE_M + cloth.size_v_m + 0.02])

    def parts(t, shift, turn):
        theta = 0.12 + down * rise(t, MOVES_AT_S, 2.6)
        shift[:, 0, UP] += cloth.size_v_m * (np.cos(theta) - 1)
        shift[:, 0, BEHIND] -= 1.04 * cloth.size_v_m * np.sin(theta)
        turn[:, 0, ALONG] += theta * 0.85

    return Motion("lay_down", True, bar(columns, rows), HANGING, origin, course_of(1, parts))


def shuttle(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A raised edge goes to and fro along itself: what lies on the table follows late."""
    height, amplitude = 0.3 * cloth.size_v_m * rng.uniform(0.9, 1.1), 0.05 * rng.uniform(0.85, 1.15)
    rate = rng.uniform(0.4, 0.5)

    def parts(t, shift, turn):
        up = rise(t, MOVES_AT_S, 0.8)
        shift[:, 0, UP] += height * up
        shift[:, 0, BEHIND] += 0.08 * cloth.size_v_m * up
        turn[:, 0, ALONG] -= 0.9 * up
        shift[:, 0, ALONG] += amplitude * wave(t, 1.2, 3.8, rate)

    return _on_table("shuttle", cloth, bar(columns, rows), parts)


def inch(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A raised edge pulls slowly, waits, gives way and pulls again: the tail sticks and lets go."""
    height, way = 0.28 * cloth.size_v_m * rng.uniform(0.9, 1.1), 0.045 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        up = rise(t, MOVES_AT_S, 0.8)
        shift[:, 0, UP] += height * up
        shift[:, 0, BEHIND] += 0.10 * cloth.size_v_m * up
        turn[:, 0, ALONG] -= 0.9 * up
        shift[:, 0, BEHIND] -= way * (rise(t, 1.3, 0.9) - 0.8 * rise(t, 2.3, 0.6) + rise(t, 3.0, 0.9))

    return _on_table("inch", cloth, bar(columns, rows), parts)


MOTIONS = {make.__name__: make for make in (trail, drag_raised, lift_off, peel, lay_down, shuttle, inch)}
