"""Scaling curves: how a policy gets better with the number of demonstrations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sim1.stage import random_stream
from sim1.statistics import Interval, bootstrap_mean_interval, wilson_interval

MIN_SIZES = 3  # a curve with two parameters through fewer points would be a drawing


@dataclass(frozen=True, kw_only=True)
class Point:
    """What was measured at one training size, all seeds together."""

    size: int  # trajectories
    seed_count: int
    held_out_count: int  # errors measured: models x held-out trajectories
    joint_error_rad: float | None
    joint_error_interval_rad: Interval | None
    hold_joint_error_rad: float | None  # of standing still, on the same trajectories
    trial_count: int
    success_count: int
    success_interval: Interval


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """error = scale_rad * size ** -exponent, least squares in logarithms."""

    scale_rad: float
    exponent: float
    exponent_interval: Interval  # bootstrap over held-out trajectories
    r_squared: float

    def at(self, size: np.ndarray) -> np.ndarray:
        return self.scale_rad * size**-self.exponent


def measure(open_loop: pd.DataFrame, trials: pd.DataFrame, sizes: Sequence[int], seed: int) -> list[Point]:
    """One point per size. The interval of the error is a bootstrap over held-out trajectories, seeds averaged first,
    because the errors of several seeds on one trajectory are not independent.
    """
    points = []
    for size in sizes:
        errors = open_loop[open_loop["size"] == size]
        runs = trials[trials["size"] == size]
        per_trajectory = _per_trajectory(errors)
        successes, tried = int(runs["success"].sum()), len(runs)
        points.append(
            Point(
                size=size,
                seed_count=errors["seed"].nunique(),
                held_out_count=len(errors),
                joint_error_rad=float(per_trajectory.mean()) if len(errors) else None,
                joint_error_interval_rad=(
                    bootstrap_mean_interval(per_trajectory, random_stream(seed, "scaling", size))
                    if len(errors)
                    else None
                ),
                hold_joint_error_rad=float(errors["hold_joint_error_rad"].mean()) if len(errors) else None,
                trial_count=tried,
                success_count=successes,
                success_interval=wilson_interval(successes, tried),
            )
        )
    return points


def fit_power_law(open_loop: pd.DataFrame, seed: int, resample_count: int = 500) -> PowerLaw | str:
    """Fit of the held-out error against size, or the reason why there is none."""
    sizes = sorted(open_loop["size"].unique())
    if len(sizes) < MIN_SIZES:
        return f"{len(sizes)} training sizes; a fitted curve needs at least {MIN_SIZES}"
    table = np.stack([_per_trajectory(open_loop[open_loop["size"] == size]) for size in sizes])  # (sizes, trajectories)
    x = np.log(np.array(sizes, dtype=float))
    slope, offset = np.polyfit(x, np.log(table.mean(axis=1)), 1)
    left = np.log(table.mean(axis=1)) - (slope * x + offset)
    spread = ((np.log(table.mean(axis=1)) - np.log(table.mean(axis=1)).mean()) ** 2).sum()
    rng = random_stream(seed, "power-law")
    picks = rng.integers(table.shape[1], size=(resample_count, table.shape[1]))
    slopes = np.polyfit(x, np.log(table[:, picks].mean(axis=2)), 1)[0]
    low, high = np.quantile(-slopes, [0.025, 0.975])
    return PowerLaw(
        scale_rad=float(np.exp(offset)),
        exponent=float(-slope),
        exponent_interval=Interval(float(low), float(high)),
        r_squared=float(1 - (left**2).sum() / spread) if spread > 0 else 1.0,
    )


def _per_trajectory(errors: pd.DataFrame) -> np.ndarray:
    """Mean over the seeds of each held-out trajectory's error, in order of garment and name."""
    return errors.groupby(["garment", "trajectory"])["joint_error_rad"].mean().to_numpy()


def equivalence() -> dict[str, object]:
    """The paper's ratio of generated to real demonstrations of the same training value, or why it is not known."""
    return {
        "ratio": None,
        "reason": "needs policies trained on demonstrations of the real robot (or of a stand-in for it) beside those "
        "trained on generated ones; this dataset holds generated trajectories alone",
    }
