"""What a comparison of movements looks at: numbers of one transition that do not say where on the table it happened."""

from dataclasses import dataclass

import numpy as np

from sim1.episode import ARMS, RATE_HZ
from sim1.motion.interpolant import minimum_jerk
from sim1.motion.likeness.smoothness import (
    log_dimensionless_jerk,
    path_ratio,
    spectral_arc_length,
    speed,
    speed_peaks,
    turned_rad,
)
from sim1.motion.poses import ToolPath

MOVES_M = 0.01  # an arm whose way is shorter rests: smoothness of rest means nothing
STAYS = 0.05  # a smaller change of openness is none
SHAPE_MODES = 3  # sines of the residual
SHAPE_FRAMES = 32  # even phases at which shapes are compared
_ARM_FEATURES = (
    "moves", "log_jerk", "sparc", "path_ratio", "peaks", "peak_speed_m_s", "mean_speed_m_s", "peak_phase", "rise_m",
    "turned_rad", "opens_phase", *(f"shape_{axis}{mode}" for axis in "xyz" for mode in range(1, SHAPE_MODES + 1)),
)  # fmt: skip
FEATURES = ("order", "duration_s", *(f"{arm}.{name}" for arm in ARMS for name in _ARM_FEATURES))


@dataclass(frozen=True, kw_only=True)
class Movement:
    """A transition, where it stands in the task, and which demonstrations its path comes from."""

    path: ToolPath  # (n) with both boundary poses, waiting at its ends cut off
    order: int  # how many transitions come before it
    sources: frozenset[str]  # the demonstration itself; of a generated path, all that its interactions are taken from

    @property
    def arms(self) -> list[int]:
        """Arms that move."""
        return [arm for arm in range(2) if _moves(self.path.position_m[:, arm])]


def features(movement: Movement) -> np.ndarray:
    """(len(FEATURES),): seconds, metres, radians and pure numbers; zeros for an arm that rests."""
    path = movement.path
    values = [float(movement.order), (len(path) - 1) / RATE_HZ]
    for arm in range(2):
        position = path.position_m[:, arm]
        if not _moves(position):
            values += [0.0] * len(_ARM_FEATURES)
            continue
        profile = speed(position)
        heights = position[:, 2]
        values += [
            1.0, log_dimensionless_jerk(position), spectral_arc_length(profile), path_ratio(position),
            float(speed_peaks(position)), profile.max(), profile.mean(), (profile.argmax() + 0.5) / len(profile),
            heights.max() - max(heights[0], heights[-1]), turned_rad(position),
            _opens_phase(path.openness[:, arm]), *_shape_modes(position),
        ]  # fmt: skip
    return np.array(values)


def canonical(position_m: np.ndarray) -> np.ndarray:
    """The way (n, 3) of one tool as a shape (SHAPE_FRAMES, 3) that does not change when it is placed or scaled.

    From the origin; turned about the vertical until its far end lies ahead (+x, or above); in units of its straight line;
    at even phases of its duration.
    """
    ahead = position_m[-1] - position_m[0]
    angle = np.arctan2(ahead[1], ahead[0]) if np.hypot(*ahead[:2]) > 1e-6 else 0.0
    c, s = np.cos(angle), np.sin(angle)
    turned = (position_m - position_m[0]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    frames, phase = np.linspace(0, 1, len(position_m)), np.linspace(0, 1, SHAPE_FRAMES)
    resampled = np.stack([np.interp(phase, frames, column) for column in turned.T], axis=-1)
    return resampled / max(float(np.linalg.norm(ahead)), MOVES_M)


def shape(movement: Movement) -> np.ndarray:
    """(2, SHAPE_FRAMES, 3) canonical ways of both tools; zeros for an arm that rests."""
    result = np.zeros((2, SHAPE_FRAMES, 3))
    for arm in movement.arms:
        result[arm] = canonical(movement.path.position_m[:, arm])
    return result


def _opens_phase(openness: np.ndarray) -> float:
    """Share of the duration after which half of the opening or closing is done; a half where the fingers stay."""
    change = openness[-1] - openness[0]
    if abs(change) < STAYS:
        return 0.5
    done = np.maximum.accumulate((openness - openness[0]) / change)
    return float(np.interp(0.5, done, np.linspace(0, 1, len(done))))


def _moves(position_m: np.ndarray) -> bool:
    return bool(np.linalg.norm(np.diff(position_m, axis=0), axis=-1).sum() > MOVES_M)


def _shape_modes(position_m: np.ndarray) -> np.ndarray:
    """(3 * SHAPE_MODES,) sine coefficients of what the canonical shape adds to minimum jerk from rest to rest."""
    way = canonical(position_m)
    phase = np.linspace(0, 1, SHAPE_FRAMES)
    straight = minimum_jerk(way[0], way[-1], phase, np.zeros(3), np.zeros(3))
    sines = np.sin(np.pi * phase[:, None] * np.arange(1, SHAPE_MODES + 1))
    return (2 / SHAPE_FRAMES * sines.T @ (way - straight)).T.ravel()
