"""What a demonstrated transition adds to the interpolant, as a few smooth modes that vanish at both ends with their slope.

Learning the residual rather than absolute poses lets a few demonstrations suffice, and the modes keep what a sampler
adds from shaking: ten sines cannot carry the jerk of frame-to-frame noise.
"""

import numpy as np

from sim1.motion.interpolant import interpolate
from sim1.motion.poses import ToolPath, from_tokens, to_tokens


def sine_modes(phase: np.ndarray, mode_count: int) -> np.ndarray:
    """(n, mode_count) values of sin(k pi s) sin(pi s), k = 1 ...; zero with its slope at s = 0 and s = 1.

    The second factor takes the slope away: a transition leaves and arrives at the speed of its neighbours.
    """
    modes = np.sin(np.pi * phase[:, None] * np.arange(1, mode_count + 1)) * np.sin(np.pi * phase)[:, None]
    modes[(phase == 0) | (phase == 1)] = 0.0
    return modes


def to_modes(residual: np.ndarray, mode_count: int) -> np.ndarray:
    """Least-squares coefficients (mode_count, c) of `residual` (n, c), sampled evenly from end to end."""
    modes = sine_modes(np.linspace(0, 1, len(residual)), mode_count)
    return np.linalg.lstsq(modes, residual, rcond=None)[0]


def residual_of(path: ToolPath, token_count: int) -> tuple[np.ndarray, ToolPath, np.ndarray, np.ndarray]:
    """Split a transition into interpolant and residual, at `token_count` even phases.

    Returns:
        Residual tokens (token_count, 20), zero at both ends; the interpolant there; velocities of both tools at the
        start and at the end [m per unit of phase], (2, 3) each.
    """
    start_rate, end_rate = end_rates(path)
    phase = np.linspace(0, 1, token_count)
    base = interpolate(path[:1], path[-1:], phase, start_rate, end_rate)
    frames = np.linspace(0, 1, len(path))
    tokens = to_tokens(path)
    resampled = np.stack([np.interp(phase, frames, column) for column in tokens.T], axis=-1)
    return resampled - to_tokens(base), base, start_rate, end_rate


def end_rates(path: ToolPath) -> tuple[np.ndarray, np.ndarray]:
    """Velocities (2, 3) of both tools over the first and last frame step [m per unit of phase]."""
    steps = len(path) - 1
    position = path.position_m
    return (position[1] - position[0]) * steps, (position[-1] - position[-2]) * steps


def assemble(
    start: ToolPath, end: ToolPath, start_rate: np.ndarray, end_rate: np.ndarray, modes: np.ndarray, frame_count: int
) -> ToolPath:
    """Interpolant plus modes (mode_count, 20) at `frame_count` even phases, both boundary poses included and exact."""
    phase = np.linspace(0, 1, frame_count)
    base = interpolate(start, end, phase, start_rate, end_rate)
    added = sine_modes(phase, len(modes)) @ modes
    moved = from_tokens(to_tokens(base) + added)
    inner = (phase > 0) & (phase < 1)
    fields = {}
    for name in ("position_m", "rotation", "openness"):
        fields[name] = getattr(base, name).copy()
        fields[name][inner] = getattr(moved, name)[inner]
    return ToolPath(**fields)
