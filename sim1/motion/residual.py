"""What a demonstrated transition adds to the interpolant, at a few even phases of its duration.

Learning the residual rather than absolute poses lets a few demonstrations suffice. The interpolant has the pose, the speed and the
acceleration of its neighbours, so that the residual vanishes at both ends with its slope.
"""

import numpy as np
from scipy.interpolate import CubicSpline

from sim1.motion.interpolant import interpolate
from sim1.motion.poses import ToolPath, from_tokens, to_tokens


def residual_of(before: ToolPath, path: ToolPath, after: ToolPath, token_count: int) -> tuple[np.ndarray, ToolPath]:
    """Split a transition into interpolant and residual, at `token_count` even phases.

    Args:
        before: ENDS frames, the last one is the first of `path`.
        path: the transition with both boundary poses.
        after: ENDS frames, the first one is the last of `path`.
        token_count: phases.

    Returns:
        Residual tokens (token_count, 20), zero at both ends; the interpolant there.
    """
    phase = np.linspace(0, 1, token_count)
    base = interpolate(before, after, phase, len(path) - 1)
    resampled = CubicSpline(np.linspace(0, 1, len(path)), to_tokens(path))(phase)
    residual = resampled - to_tokens(base)
    residual[[0, -1]] = 0.0
    return residual, base


def assemble(before: ToolPath, after: ToolPath, residual: np.ndarray, frame_count: int) -> ToolPath:
    """Interpolant plus residual at `frame_count` even phases, both boundary poses included and exact.

    Args:
        before: ENDS frames, the last one is the start pose.
        after: ENDS frames, the first one is the end pose.
        residual: (n, 20) at n even phases, zero at both ends; between them a cubic spline that leaves and arrives level.
        frame_count: of the path.
    """
    phase = np.linspace(0, 1, frame_count)
    base = interpolate(before, after, phase, frame_count - 1)
    added = CubicSpline(np.linspace(0, 1, len(residual)), residual, bc_type="clamped")(phase)
    moved = from_tokens(to_tokens(base) + added)
    inner = (phase > 0) & (phase < 1)
    fields = {}
    for name in ("position_m", "rotation", "openness"):
        fields[name] = getattr(base, name).copy()
        fields[name][inner] = getattr(moved, name)[inner]
    return ToolPath(**fields)
