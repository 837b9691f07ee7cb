"""Faults of a drive's path: steps that no arm makes, and stretches without a command."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.stage import BadInput

FASTEST_M_S, FASTEST_RAD_S = 10.0, 60.0  # no arm moves its gripper faster: such a step is a fault of the stream
HARDEST_M_S2, HARDEST_RAD_S2 = 50.0, 500.0  # nor sets it off harder: 5 g, and as much 0.1 m beside its axis
SMALLEST_JUMP_M, SMALLEST_JUMP_RAD = 0.02, 0.2  # below this, jitter of poses and of time stamps makes both meaningless
LONGEST_JUMP = 2  # samples that a jump is spread over, where a stream was interpolated
LONGEST_GAP_S, MOVED_IN_GAP_M = 0.5, 0.02


def check_path(
    place: Callable[[int], str], time_s: np.ndarray, position_m: np.ndarray, rotation_wxyz: np.ndarray
) -> None:
    """Check the path of one drive, n samples; `place` is where a sample stands.

    Raises:
        BadInput: it moves or turns in a step further than an arm can from how it moves before and after, or moves unseen in a long gap.
    """
    turn = Rotation.from_quat(rotation_wxyz, scalar_first=True)
    moves = (lambda k: position_m[k:] - position_m[:-k]), FASTEST_M_S, HARDEST_M_S2, SMALLEST_JUMP_M
    turns = (lambda k: (turn[:-k].inv() * turn[k:]).as_rotvec()), FASTEST_RAD_S, HARDEST_RAD_S2, SMALLEST_JUMP_RAD
    kinds = ("jumps", "m", "millimetres", moves), ("turns", "rad", "qw not first", turns)
    for verb, unit, mistake, (over, fastest, hardest, smallest) in kinds:
        for samples in range(1, min(LONGEST_JUMP, len(time_s) - 1) + 1):
            way, took = np.linalg.norm(over(samples), axis=1), _took_s(time_s, samples)
            need = _acceleration(over, time_s, samples)
            if (jump := (way > smallest) & ((way / took > fastest) | (need > hardest))).any():
                at = int(np.argmax(jump))
                raise BadInput(
                    f"{place(at + samples)}: the drive {verb} by {way[at]:.3g} {unit} in "
                    f"{time_s[at + samples] - time_s[at]:.3g} s at {time_s[at + samples]} s, from how it moves before and after {need[at]:.3g} {unit}/s^2 at least; an arm makes at most "
                    f"{fastest:g} {unit}/s and {hardest:g} {unit}/s^2: repair the stream (a lost packet, or {mistake})"
                )
    step, moved = np.diff(time_s), np.linalg.norm(np.diff(position_m, axis=0), axis=1)
    if (gap := (step > LONGEST_GAP_S) & (moved > MOVED_IN_GAP_M)).any():
        at = int(np.argmax(gap)) + 1
        raise BadInput(
            f"{place(at)}: no command for {step[at - 1]:.3g} s before {time_s[at]} s, while the drive moves by "
            f"{moved[at - 1]:.3g} m; record again, or cut the recording there"
        )


def _acceleration(over: Callable[[int], np.ndarray], time_s: np.ndarray, samples: int) -> np.ndarray:
    """Least acceleration of each way over so many samples, (n - samples,), from the faster of the steps before and after it.

    A way d in a time t that begins and ends at a speed v takes 4 (d - v t) / t^2, harder first and braking then. Speeds of the steps
    beside it count along it, so that a jump and its way back do not excuse each other. `over(k)` is the way (n - k, 3) over k samples.
    """
    took = _took_s(time_s, samples)
    way, step = over(samples), over(1) / _took_s(time_s, 1)[:, None]
    size = np.linalg.norm(way, axis=1)
    along = way / np.maximum(size, 1e-12)[:, None]
    before = np.concatenate([np.zeros((1, 3)), step[: len(way) - 1]])
    after = np.concatenate([step[samples:], np.zeros((1, 3))])
    beside = np.maximum((before * along).sum(1), (after * along).sum(1))
    return 4.0 * (size - np.maximum(beside, 0.0) * took) / took**2


def _took_s(time_s: np.ndarray, samples: int) -> np.ndarray:
    """Time of each so many samples, (n - samples,); stamps that are closer than in the mean, gaps left out, came in a burst."""
    steps = np.diff(time_s)
    mean_s = float(steps[steps < LONGEST_GAP_S].mean()) if (steps < LONGEST_GAP_S).any() else 0.0
    return np.maximum(time_s[samples:] - time_s[:-samples], samples * mean_s)
