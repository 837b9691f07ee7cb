"""Faults of a drive's path: steps that no arm makes, and stretches without a command."""

from collections.abc import Callable

import numpy as np

from sim1.stage import BadInput

FASTEST_M_S, FASTEST_RAD_S = 10.0, 60.0  # no arm moves its gripper faster: such a step is a fault of the stream
SMALLEST_JUMP_M, SMALLEST_JUMP_RAD = 0.03, 0.3  # below this, jitter of the time stamps makes speeds meaningless
LONE_JUMP_M, LONE_M_S, LONE_RATIO = 0.05, 2.0, 8.0  # a step this many times as long as its neighbours stands alone
LONGEST_GAP_S, MOVED_IN_GAP_M = 0.5, 0.02


def check_path(
    place: str, time_s: np.ndarray, position_m: np.ndarray, rotation_wxyz: np.ndarray, row_of: Callable[[int], int]
) -> None:
    """Check the path of one drive, n samples; `place` starts messages, `row_of` gives the row of a sample in the file.

    Raises:
        BadInput: it jumps, turns in one step further than an arm can, or moves unseen in a long gap.
    """
    step = np.diff(time_s)
    moved = np.linalg.norm(np.diff(position_m, axis=0), axis=1)
    fast = (moved > SMALLEST_JUMP_M) & (moved / step > FASTEST_M_S)
    alone = (moved > LONE_JUMP_M) & (moved / step > LONE_M_S) & (moved > LONE_RATIO * _beside(moved))
    if (jump := fast | alone).any():
        at = int(np.argmax(jump)) + 1
        raise BadInput(
            f"{place}: row {row_of(at)}: the drive jumps by {moved[at - 1]:.3g} m in {step[at - 1]:.3g} s at {time_s[at]} s; "
            "repair the stream (a lost packet, or millimetres)"
        )
    turned = 2 * np.arccos(np.clip(np.abs((rotation_wxyz[1:] * rotation_wxyz[:-1]).sum(1)), 0, 1))
    if (jump := (turned > SMALLEST_JUMP_RAD) & (turned / step > FASTEST_RAD_S)).any():
        at = int(np.argmax(jump)) + 1
        raise BadInput(
            f"{place}: row {row_of(at)}: the drive turns by {turned[at - 1]:.3g} rad in {step[at - 1]:.3g} s; "
            "repair the stream (a lost packet, or qw not first)"
        )
    if (gap := (step > LONGEST_GAP_S) & (moved > MOVED_IN_GAP_M)).any():
        at = int(np.argmax(gap)) + 1
        raise BadInput(
            f"{place}: row {row_of(at)}: no command for {step[at - 1]:.3g} s before {time_s[at]} s, while the drive moves by "
            f"{moved[at - 1]:.3g} m; record again, or cut the recording there"
        )


def _beside(moved: np.ndarray) -> np.ndarray:
    """Longest of the two steps before and the two after each step, (n,); a jump and its way back do not excuse each other."""
    padded = np.pad(moved, 2)
    around = np.lib.stride_tricks.sliding_window_view(padded, 5)[:, [0, 1, 3, 4]]
    return np.sort(around, axis=1)[:, -2]
