"""How long a transition takes: a readable regression on how far the tools travel and turn, corrected by what transitions like
it took in the demonstrations.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

from sim1.episode import RATE_HZ
from sim1.motion.poses import ToolPath

# Two transitions are alike when they differ by less than this in travel [m], turn [rad], rise [m], speed [m/s] at start and end.
ALIKE = np.array([0.03, 0.2, 0.03, 0.05, 0.05])
UNKNOWN_SPREAD = 0.05  # of the logarithm, where too few demonstrations show one


@dataclass(frozen=True, kw_only=True)
class DurationModel:
    """duration = rest_s + s_per_m * travel + s_per_rad * turn, times what similar transitions took, times a spread."""

    rest_s: float
    s_per_m: float
    s_per_rad: float
    log_std: float  # of the demonstrations about what is expected, at most 0.3
    examples: tuple[
        tuple[float, ...], ...
    ] = ()  # of each demonstrated transition: the five of ALIKE, then log(seconds / line)

    def mean_s(self, before: ToolPath, after: ToolPath) -> float:
        """Expected duration between the last pose of `before` and the first of `after`, two frames or more each."""
        asked = description(before, after)
        line = self.rest_s + self.s_per_m * asked[0] + self.s_per_rad * asked[1]
        return float(line * np.exp(_correction(np.array(self.examples), asked)))

    def sample_steps(self, before: ToolPath, after: ToolPath, rng: np.random.Generator) -> int:
        """A random duration in frame steps, at least 5."""
        spread = np.exp(self.log_std * np.clip(rng.standard_normal(), -2, 2))
        return max(round(self.mean_s(before, after) * spread * RATE_HZ), 5)


def description(before: ToolPath, after: ToolPath) -> np.ndarray:
    """(5,) travel [m], turn [rad] and rise [m] of the tool that has most of it to do, speeds [m/s] at both ends."""
    way = after.position_m[0] - before.position_m[-1]
    turn = Rotation.from_matrix(before.rotation[-1].swapaxes(-1, -2) @ after.rotation[0]).magnitude().max()
    rise = way[np.abs(way[:, 2]).argmax(), 2]
    ends = (before.position_m[-1] - before.position_m[-2], after.position_m[1] - after.position_m[0])
    speeds = [np.linalg.norm(step, axis=-1).max() * RATE_HZ for step in ends]
    return np.array([np.linalg.norm(way, axis=-1).max(), turn, rise, *speeds])


def fitted_durations(ends: list[tuple[ToolPath, ToolPath]], seconds: list[float]) -> DurationModel:
    """Least squares with coefficients that are not negative (further never means sooner), and the examples themselves.

    Args:
        ends: what came before and after each transition.
        seconds: how long it took.
    """
    asked = np.array([description(*pair) for pair in ends])
    taken = np.array(seconds)
    (rest, per_m, per_rad), _ = nnls(np.column_stack([np.ones(len(asked)), asked[:, :2]]), taken)
    rest = max(rest, 0.2)  # even a transition of no length needs a moment
    examples = np.column_stack([asked, np.log(taken / (rest + per_m * asked[:, 0] + per_rad * asked[:, 1]))])
    errors = [row[-1] - _correction(np.delete(examples, i, axis=0), row[:-1]) for i, row in enumerate(examples)]
    spread = float(np.std(errors)) if len(errors) > 3 else UNKNOWN_SPREAD
    return DurationModel(
        rest_s=float(rest), s_per_m=float(per_m), s_per_rad=float(per_rad), log_std=min(spread, 0.3),
        examples=tuple(tuple(row) for row in examples.tolist()),
    )  # fmt: skip


def _correction(examples: np.ndarray, asked: np.ndarray) -> float:
    """Mean log ratio of the examples, each weighing less the less it is like what is asked; the nearest always counts."""
    if not len(examples):
        return 0.0
    apart = (((examples[:, :-1] - asked) / ALIKE) ** 2).sum(axis=1) / 2
    weight = np.exp(apart.min() - apart)
    return float(weight @ examples[:, -1] / weight.sum())
