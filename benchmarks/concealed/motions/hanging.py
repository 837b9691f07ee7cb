"""Motions of a sheet that hangs from two corner grippers or from a clamp: still, swings, twist, tilt, bounce."""

import numpy as np

from benchmarks.concealed.cloth import Cloth
from benchmarks.concealed.motions.motion import HANGING, MOVES_AT_S, Motion, bar, corners, course_of, hanging_origin
from benchmarks.concealed.motions.paths import rise, there_and_back, wave

LEFT, RIGHT = 0, 1
ALONG, OUT, UP = 0, 1, 2


TAUT = 0.005
"""Strain between the corners: without it their edge, which the sheet's weight presses together, may bow to either side."""


def _from_corners(name: str, cloth: Cloth, columns: int, rows: int, parts, slack: float = -TAUT) -> Motion:
    """Corner grippers; nearer than the sheet is wide by a share `slack`, they are turned in so that it hangs in an arc.

    Turned in by about half of what the arc would have at its ends: with more, the sheet may fold in two ways.
    """
    toe_in = 1.2 * np.sqrt(max(slack, 0.0))

    def all_parts(t: np.ndarray, shift: np.ndarray, turn: np.ndarray) -> None:
        shift[:, LEFT, ALONG] += slack / 2 * cloth.size_u_m
        shift[:, RIGHT, ALONG] -= slack / 2 * cloth.size_u_m
        turn[:, LEFT, UP] += toe_in
        turn[:, RIGHT, UP] -= toe_in
        parts(t, shift, turn)

    return Motion(name, False, corners(columns, rows), HANGING, hanging_origin(cloth), course_of(2, all_parts))


def _from_bar(name: str, cloth: Cloth, columns: int, rows: int, parts) -> Motion:
    return Motion(name, False, bar(columns, rows), HANGING, hanging_origin(cloth), course_of(1, parts))


def hang(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """Both corners a few millimetres down, once; then the sheet hangs still."""
    way = 0.006 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        shift[:, :, UP] -= (way * rise(t, MOVES_AT_S, 0.5))[:, None]

    return _from_corners("hang", cloth, columns, rows, parts)


def swing_out(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """Both corners to and fro out of the plane, slowly, then let it swing."""
    amplitude, rate = 0.03 * rng.uniform(0.85, 1.15), rng.uniform(0.45, 0.6)

    def parts(t, shift, turn):
        shift[:, :, OUT] += (amplitude * wave(t, MOVES_AT_S, 3.2, rate))[:, None]

    return _from_corners("swing_out", cloth, columns, rows, parts)


def fast_swing(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A clamp quickly to a place out of the plane and back."""
    way, duration = 0.14 * rng.uniform(0.85, 1.15), rng.uniform(0.6, 0.75)

    def parts(t, shift, turn):
        shift[:, 0, OUT] += way * there_and_back(t, MOVES_AT_S, duration, 0.5)

    return _from_bar("fast_swing", cloth, columns, rows, parts)


def swing_in_plane(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """Both corners to and fro along the sheet."""
    amplitude, rate = 0.05 * rng.uniform(0.85, 1.15), rng.uniform(0.6, 0.8)

    def parts(t, shift, turn):
        shift[:, :, ALONG] += (amplitude * wave(t, MOVES_AT_S, 3.2, rate))[:, None]

    return _from_corners("swing_in_plane", cloth, columns, rows, parts)


def twist(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The corners circle about the vertical middle line and turn with it."""
    angle, rate = 0.3 * rng.uniform(0.85, 1.15), rng.uniform(0.4, 0.55)

    def parts(t, shift, turn):
        theta = angle * wave(t, MOVES_AT_S, 3.3, rate)
        arm = shift[:, :, ALONG] + np.array([-0.5, 0.5]) * cloth.size_u_m * (1 - 1 / (columns - 1))
        shift[:, :, ALONG] += arm * (np.cos(theta) - 1)[:, None]
        shift[:, :, OUT] += arm * np.sin(theta)[:, None]
        turn[:, :, UP] += theta[:, None]

    return _from_corners("twist", cloth, columns, rows, parts, slack=0.05)


def corner_lift(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The right corner goes up on a circle about the left one, stays, and comes back."""
    angle = 0.22 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        theta = angle * there_and_back(t, MOVES_AT_S, 1.2, 0.4)
        arm = cloth.size_u_m * (1 + TAUT - 1 / (columns - 1))
        shift[:, RIGHT, ALONG] += arm * (np.cos(theta) - 1)
        shift[:, RIGHT, UP] += arm * np.sin(theta)
        turn[:, :, OUT] -= theta[:, None]

    return _from_corners("corner_lift", cloth, columns, rows, parts)


def heave(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """Both corners up and down: the weight in the grips changes."""
    amplitude, rate = 0.05 * rng.uniform(0.85, 1.15), rng.uniform(0.9, 1.2)

    def parts(t, shift, turn):
        shift[:, :, UP] += (amplitude * wave(t, MOVES_AT_S, 3.2, rate))[:, None]

    return _from_corners("heave", cloth, columns, rows, parts, slack=0.05)


def spread(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """The corners slowly apart until the upper edge is stretched, back, and apart again, in grips that lean forward."""
    strain = 0.035 * rng.uniform(0.9, 1.1)

    def parts(t, shift, turn):
        way = cloth.size_u_m * strain * (there_and_back(t, MOVES_AT_S, 0.8, 0.2) + 0.7 * rise(t, 2.6, 0.8))
        shift[:, LEFT, ALONG] -= way / 2
        shift[:, RIGHT, ALONG] += way / 2
        turn[:, :, ALONG] += 0.35

    return _from_corners("spread", cloth, columns, rows, parts)


def bar_swing(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A clamp along the whole edge to and fro out of the plane."""
    amplitude, rate = 0.06 * rng.uniform(0.85, 1.15), rng.uniform(0.6, 0.85)

    def parts(t, shift, turn):
        shift[:, 0, OUT] += amplitude * wave(t, MOVES_AT_S, 3.0, rate)

    return _from_bar("bar_swing", cloth, columns, rows, parts)


def bar_tilt(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A clamp turns about its edge until the sheet starts level from it, to both sides: a cantilever."""
    angle = 1.3 * rng.uniform(0.85, 1.1)

    def parts(t, shift, turn):
        turn[:, 0, ALONG] += angle * (rise(t, MOVES_AT_S, 0.9) - 2 * rise(t, 1.7, 1.3))

    return _from_bar("bar_tilt", cloth, columns, rows, parts)


def bar_roll(cloth: Cloth, columns: int, rows: int, rng: np.random.Generator) -> Motion:
    """A clamp turns in the plane of the sheet and about the vertical."""
    angle, yaw = 0.3 * rng.uniform(0.85, 1.15), 0.5 * rng.uniform(0.85, 1.15)

    def parts(t, shift, turn):
        turn[:, 0, OUT] += angle * there_and_back(t, MOVES_AT_S, 1.0, 0.3)
        turn[:, 0, UP] += yaw * wave(t, 1.0, 3.4, 0.6)

    return _from_bar("bar_roll", cloth, columns, rows, parts)


MOTIONS = {
    make.__name__: make
    for make in (
        hang,
        swing_out,
        fast_swing,
        swing_in_plane,
        twist,
        corner_lift,
        heave,
        spread,
        bar_swing,
        bar_tilt,
        bar_roll,
    )
}
