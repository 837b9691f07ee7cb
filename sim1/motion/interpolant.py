"""The path without character between two poses: minimum jerk for positions, SLERP for rotations."""

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.motion.poses import ToolPath


def minimum_jerk(
    start: np.ndarray, end: np.ndarray, phase: np.ndarray, start_rate: np.ndarray, end_rate: np.ndarray
) -> np.ndarray:
    """Quintic with given ends, given rates there (per unit of phase) and no acceleration there.

    At rest at both ends it is start + (end - start) (10 s^3 - 15 s^4 + 6 s^5).
    Source: Flash and Hogan 1985, equation 5, for general boundary rates.

    Args:
        start: (...,)
        end: (...,)
        phase: (n,) from 0 to 1.
        start_rate: (...,)
        end_rate: (...,)

    Returns:
        (n, ...)
    """
    s = phase.reshape((-1,) + (1,) * np.ndim(start))
    step = end - start
    cubic = 10 * step - 6 * start_rate - 4 * end_rate
    quartic = -15 * step + 8 * start_rate + 7 * end_rate
    quintic = 6 * step - 3 * (start_rate + end_rate)
    return start + start_rate * s + cubic * s**3 + quartic * s**4 + quintic * s**5


def slerp(start: np.ndarray, end: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) on the shortest way from `start` to `end` (3, 3), at shares (n,) of the angle."""
    turn = Rotation.from_matrix(start.T @ end).as_rotvec()
    return start @ Rotation.from_rotvec(share[:, None] * turn).as_matrix()


def interpolate(
    start: ToolPath, end: ToolPath, phase: np.ndarray, start_rate: np.ndarray, end_rate: np.ndarray
) -> ToolPath:
    """Both tools from a pose to another; the ends are met exactly.

    Args:
        start: one frame.
        end: one frame.
        phase: (n,) from 0 to 1.
        start_rate: (2, 3) velocity at the start [m per unit of phase].
        end_rate: (2, 3) velocity at the end [m per unit of phase].
    """
    still = np.zeros(())
    share = minimum_jerk(np.zeros(()), np.ones(()), phase, still, still)
    arms = [slerp(start.rotation[0, arm], end.rotation[0, arm], share) for arm in range(2)]
    openness = start.openness[0] + share[:, None] * (end.openness[0] - start.openness[0])
    position = minimum_jerk(start.position_m[0], end.position_m[0], phase, start_rate, end_rate)
    path = ToolPath(position_m=position, rotation=np.stack(arms, axis=1), openness=openness)
    return _with_exact_ends(path, start, end, phase)


def straight(start: ToolPath, end: ToolPath, steps: int) -> ToolPath:
    """Straight lines at constant speed between one-frame poses, steps + 1 frames; as MimicGen bridges its slices."""
    share = np.linspace(0, 1, steps + 1)
    path = ToolPath(
        position_m=start.position_m + share[:, None, None] * (end.position_m - start.position_m),
        rotation=np.stack([slerp(start.rotation[0, arm], end.rotation[0, arm], share) for arm in range(2)], axis=1),
        openness=start.openness + share[:, None] * (end.openness - start.openness),
    )
    return _with_exact_ends(path, start, end, share)


def _with_exact_ends(path: ToolPath, start: ToolPath, end: ToolPath, phase: np.ndarray) -> ToolPath:
    """Rounding taken out of the frames at phase 0 and 1, so that a boundary pose is the given one to the last bit."""
    fields = {}
    for name in ("position_m", "rotation", "openness"):
        values = getattr(path, name).copy()
        values[phase == 0] = getattr(start, name)[0]
        values[phase == 1] = getattr(end, name)[0]
        fields[name] = values
    return ToolPath(**fields)
