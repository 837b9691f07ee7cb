"""How long a transition takes: a readable regression on how far the tools travel and turn."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

from sim1.episode import RATE_HZ
from sim1.motion.poses import ToolPath


@dataclass(frozen=True, kw_only=True)
class DurationModel:
    """duration = rest_s + s_per_m * travel + s_per_rad * turn, times a log-normal spread."""

    rest_s: float
    s_per_m: float
    s_per_rad: float
    log_std: float  # of the demonstrations about the line, at most 0.3

    def mean_s(self, start: ToolPath, end: ToolPath) -> float:
        """Expected duration between two one-frame poses."""
        travel, turn = distance(start, end)
        return self.rest_s + self.s_per_m * travel + self.s_per_rad * turn

    def sample_steps(self, start: ToolPath, end: ToolPath, rng: np.random.Generator) -> int:
        """A random duration in frame steps, at least 5."""
        spread = np.exp(self.log_std * np.clip(rng.standard_normal(), -2, 2))
        return max(round(self.mean_s(start, end) * spread * RATE_HZ), 5)


def distance(start: ToolPath, end: ToolPath) -> tuple[float, float]:
    """Travel [m] and turn [rad] of the tool that has more of it to do."""
    travel = np.linalg.norm(end.position_m[0] - start.position_m[0], axis=-1).max()
    turn = Rotation.from_matrix(start.rotation[0].swapaxes(-1, -2) @ end.rotation[0]).magnitude().max()
    return float(travel), float(turn)


def fitted_durations(paths: list[ToolPath]) -> DurationModel:
    """Least squares with coefficients that are not negative: further never means sooner."""
    rows = np.array([[1.0, *distance(path[:1], path[-1:])] for path in paths])
    seconds = np.array([(len(path) - 1) / RATE_HZ for path in paths])
    (rest, per_m, per_rad), _ = nnls(rows, seconds)
    rest = max(rest, 0.2)  # even a transition of no length needs a moment
    predicted = rest + rows[:, 1] * per_m + rows[:, 2] * per_rad
    spread = float(np.std(np.log(seconds / predicted))) if len(paths) > 2 else 0.1
    return DurationModel(rest_s=float(rest), s_per_m=float(per_m), s_per_rad=float(per_rad), log_std=min(spread, 0.3))
