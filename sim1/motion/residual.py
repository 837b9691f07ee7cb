"""What a demonstrated transition adds to the interpolant, as a few smooth modes that vanish at both ends.

Learning the residual rather than absolute poses lets a few demonstrations suffice, and the modes keep what a sampler
adds from shaking: ten sines cannot carry the jerk of frame-to-frame noise.
"""

import numpy as np
from scipy.interpolate import CubicSpline

from sim1.motion.interpolant import interpolate
from sim1.motion.poses import ToolPath, from_tokens, to_tokens


def sine_modes(phase: np.ndarray, mode_count: int) -> np.ndarray:
    """(n, mode_count) values of sin(k pi s) sin(pi s)^2, k = 1 ...; zero at s = 0 and 1 with slope and curvature.

    The second factor takes slope and curvature away: a transition leaves and arrives at the speed and the acceleration of
    its neighbours.
    """
    modes = np.sin(np.pi * phase[:, None] * np.arange(1, mode_count + 1)) * np.sin(np.pi * phase)[:, None] ** 2
    modes[(phase == 0) | (phase == 1)] = 0.0
    return modes


def to_modes(residual: np.ndarray, mode_count: int) -> np.ndarray:
    """Least-squares coefficients (mode_count, c) of `residual` (n, c), sampled evenly from end to end."""
    modes = sine_modes(np.linspace(0, 1, len(residual)), mode_count)
    return np.linalg.lstsq(modes, residual, rcond=None)[0]


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


def assemble(before: ToolPath, after: ToolPath, modes: np.ndarray, frame_count: int) -> ToolPath:
    """Interpolant plus modes (mode_count, 20) at `frame_count` even phases, both boundary poses included and exact."""
    phase = np.linspace(0, 1, frame_count)
    base = interpolate(before, after, phase, frame_count - 1)
    moved = from_tokens(to_tokens(base) + sine_modes(phase, len(modes)) @ modes)
    inner = (phase > 0) & (phase < 1)
    fields = {}
    for name in ("position_m", "rotation", "openness"):
        fields[name] = getattr(base, name).copy()
        fields[name][inner] = getattr(moved, name)[inner]
    return ToolPath(**fields)
