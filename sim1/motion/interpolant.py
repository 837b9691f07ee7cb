"""The path without character between two motions: minimum jerk for positions, SLERP for rotations, smooth at both joins.

Velocity of the tools goes on through the whole path (the boundary rates of the quintic). What is left to match, accelerations and
turning, is matched within BLEND_S of the ends: measured over three frames it is too uncertain to shape the whole way.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.episode import RATE_HZ
from sim1.motion.poses import ToolPath

ENDS = 3  # frames on either side that a transition goes on from and into
BLEND_S = 0.8  # within which it takes over their acceleration and turning


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


def quintic_weights(phase: np.ndarray, steps: int) -> np.ndarray:
    """(n, 2 * ENDS) shares, at each phase, of frames that a quintic goes through: ENDS up to phase 0, ENDS from phase 1.

    Of all paths through these frames it has the smallest sum of squared third differences (its sixth ones vanish), which is
    minimum jerk in discrete time.

    Args:
        phase: (n,)
        steps: frame steps from phase 0 to phase 1.
    """
    ahead = np.arange(ENDS) / steps
    nodes = np.concatenate([-ahead[::-1], 1 + ahead])
    result = np.empty((len(phase), len(nodes)))
    for index, node in enumerate(nodes):
        others = np.delete(nodes, index)
        result[:, index] = np.prod((phase[:, None] - others) / (node - others), axis=1)
    return result


def interpolate(before: ToolPath, after: ToolPath, phase: np.ndarray, steps: int) -> ToolPath:
    """Both tools from a motion to another; the boundary poses are met exactly.

    Args:
        before: ENDS frames, the last one is the start pose.
        after: ENDS frames, the first one is the end pose.
        phase: (n,) from 0 to 1.
        steps: frame steps from start pose to end pose.
    """
    plain = _plain(before, after, phase, steps)
    ahead = np.arange(1, ENDS) / steps
    into = _local(phase, steps) @ _missing(_plain(before, after, -ahead[::-1], steps), before[:-1])
    out = _local(1 - phase, steps) @ _missing(_plain(before, after, 1 + ahead[::-1], steps), after[:0:-1])
    added = (into + out).reshape(len(phase), 2, 7)
    path = ToolPath(
        position_m=plain.position_m + added[..., :3],
        rotation=plain.rotation @ _rotations(added[..., 3:6]),
        openness=np.clip(plain.openness + added[..., 6], 0, 1),
    )
    return _with_exact_ends(path, before[-1:], after[:1], phase)


def _plain(before: ToolPath, after: ToolPath, phase: np.ndarray, steps: int) -> ToolPath:
    """Minimum jerk with the speeds of the neighbours; phases outside [0, 1] go on with the same polynomials."""
    still = np.zeros(())
    share = minimum_jerk(np.zeros(()), np.ones(()), phase, still, still)
    start_rate = (before.position_m[-1] - before.position_m[-2]) * steps
    end_rate = (after.position_m[1] - after.position_m[0]) * steps
    turned = [slerp(before.rotation[-1, arm], after.rotation[0, arm], share) for arm in range(2)]
    return ToolPath(
        position_m=minimum_jerk(before.position_m[-1], after.position_m[0], phase, start_rate, end_rate),
        rotation=np.stack(turned, axis=1),
        openness=before.openness[-1] + share[:, None] * (after.openness[0] - before.openness[-1]),
    )


def _missing(plain: ToolPath, given: ToolPath) -> np.ndarray:
    """(ENDS - 1, 14) what frames of a neighbour have beyond the plain path: metres, rotation vectors, openness."""
    turn = Rotation.from_matrix((plain.rotation.swapaxes(-1, -2) @ given.rotation).reshape(-1, 3, 3)).as_rotvec()
    parts = [
        given.position_m - plain.position_m, turn.reshape(-1, 2, 3), (given.openness - plain.openness)[..., None]
    ]  # fmt: skip
    return np.concatenate(parts, axis=-1).reshape(len(given), -1)


def _local(phase: np.ndarray, steps: int) -> np.ndarray:
    """(n, ENDS - 1) shares of what is missing in the frames before phase 0, which fade within BLEND_S."""
    length = min(round(BLEND_S * RATE_HZ), steps // 2)
    local = phase * steps / length
    return quintic_weights(local, length)[:, : ENDS - 1] * (local < 1)[:, None]


def _rotations(vectors: np.ndarray) -> np.ndarray:
    return Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(*vectors.shape, 3)


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
