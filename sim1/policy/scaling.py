"""Scaling curves: how a policy gets better with the number of trajectories that it learnt from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sim1.clustered_share import Difference
from sim1.policy import paper
from sim1.policy.error_table import RESAMPLES, error_table, interval_about, interval_of, means_of_resamples
from sim1.policy.lessons import GENERATED, KINDS, REAL
from sim1.policy.success_law import MIN_SIZES
from sim1.policy.tried import Tried, compare, count
from sim1.stage import random_stream
from sim1.statistics import Interval


@dataclass(frozen=True, kw_only=True)
class Error:
    """Action error on held-out trajectories of one kind."""

    tested_on: str
    count: int  # errors measured: models x held-out trajectories
    source_count: int  # held-out demonstrations that these come from
    joint_error_rad: float
    interval_rad: Interval | None  # bootstrap over demonstrations and networks; None: there is one demonstration
    hold_joint_error_rad: float  # of standing still, on the same trajectories


@dataclass(frozen=True, kw_only=True)
class Point:
    """What was measured at one training size, all seeds together."""

    trained_on: str
    size: int  # trajectories
    seed_count: int
    errors: tuple[Error, ...]
    trials: tuple[Tried, ...]  # by shift
    all_trials: Tried | None  # of all shifts together; None: none was run


@dataclass(frozen=True, kw_only=True)
class Task:
    """Trials with one garment, laid down as it was demonstrated, after the largest number of generated trajectories."""

    garment: str
    size: int
    tried: Tried


@dataclass(frozen=True, kw_only=True)
class PowerLaw:
    """error = scale_rad * size ** -exponent, least squares in logarithms."""

    trained_on: str
    tested_on: str
    size_count: int
    scale_rad: float
    exponent: float
    exponent_interval: Interval | None  # as that of an error
    r_squared: float

    def at(self, size: np.ndarray) -> np.ndarray:
        """Error [rad] at sizes (n,)."""
        return self.scale_rad * size**-self.exponent


def measure(open_loop: pd.DataFrame, trials: pd.DataFrame, sizes: dict[str, Sequence[int]], seed: int) -> list[Point]:
    """One point per kind of training trajectories and size (`sizes` by kind)."""
    points = []
    for kind, size in ((kind, size) for kind, some in sizes.items() for size in some):
        errors = open_loop[(open_loop["trained_on"] == kind) & (open_loop["size"] == size)]
        runs = trials[(trials["trained_on"] == kind) & (trials["size"] == size)]
        points.append(
            Point(
                trained_on=kind,
                size=size,
                seed_count=len({*errors["seed"], *runs["seed"]}),
                errors=tuple(
                    _error(errors[errors["tested_on"] == tested], tested, seed)
                    for tested in KINDS
                    if (errors["tested_on"] == tested).any()
                ),
                trials=tuple(count(runs[runs["shift"] == shift], shift) for shift in dict.fromkeys(runs["shift"])),
                all_trials=count(runs, paper.AVERAGE) if len(runs) else None,
            )
        )
    return points


def measure_tasks(trials: pd.DataFrame) -> list[Task]:
    """One per garment that was tried in-domain."""
    runs = trials[(trials["trained_on"] == GENERATED) & (trials["shift"] == "in-domain")]
    largest = runs[runs["size"] == runs["size"].max()]
    return [
        Task(garment=garment, size=int(own["size"].iloc[0]), tried=count(own, "in-domain"))
        for garment, own in largest.groupby("garment", sort=False)
    ]


def measure_over_real(trials: pd.DataFrame) -> dict[str, Difference]:
    """Success after generated trajectories minus that after real demonstrations, at the largest number of either that drove.

    By shift, and `paper.AVERAGE` over all; over trials from the same placements. Empty where there is no pair.
    """
    of = {kind: trials[trials["trained_on"] == kind] for kind in (GENERATED, REAL)}
    generated, real = (runs[runs["size"] == runs["size"].max()] for runs in of.values())
    parts = {shift: (generated[generated["shift"] == shift], real) for shift in dict.fromkeys(generated["shift"])}
    found = {
        name: compare(*sides, also=["shift"]) for name, sides in {**parts, paper.AVERAGE: (generated, real)}.items()
    }
    return {name: difference for name, difference in found.items() if difference}


def _error(errors: pd.DataFrame, tested_on: str, seed: int) -> Error:
    table, size = error_table(errors), int(errors["size"].iloc[0])
    return Error(
        tested_on=tested_on,
        count=len(errors),
        source_count=table.source_count,
        joint_error_rad=float(table.errors.mean()),
        interval_rad=interval_of(table, random_stream(seed, "scaling", size), least=0.0),
        hold_joint_error_rad=float(errors["hold_joint_error_rad"].mean()),
    )


def fit_power_laws(open_loop: pd.DataFrame, seed: int) -> list[PowerLaw]:
    """Of every kind of training and of test trajectories with enough sizes."""
    kinds = open_loop.groupby(["trained_on", "tested_on"], sort=True)
    fits = (fit_power_law(rows, seed) for _, rows in kinds)
    return [fit for fit in fits if isinstance(fit, PowerLaw)]


def fit_power_law(open_loop: pd.DataFrame, seed: int) -> PowerLaw | str:
    """Fit of the held-out error against size, of one kind of training and test, or the reason why there is none."""
    sizes = sorted(open_loop["size"].unique())
    if len(sizes) < MIN_SIZES:
        return f"{len(sizes)} training sizes; a fitted curve needs at least {MIN_SIZES}"
    found = [error_table(open_loop[open_loop["size"] == size]) for size in sizes]
    tables = np.stack([one.errors for one in found])  # of the same trajectories, whatever the size
    x, y = np.log(np.array(sizes, dtype=float)), np.log(tables.mean(axis=(1, 2)))
    slope, offset = np.polyfit(x, y, 1)
    left, spread = y - (slope * x + offset), ((y - y.mean()) ** 2).sum()
    # Networks of one seed learnt from nested sets, whatever the size: they are drawn together.
    resampled = means_of_resamples(tables, found[0].sources, RESAMPLES, random_stream(seed, "power-law"))
    exponents = -np.polyfit(x, np.log(resampled), 1)[0]
    return PowerLaw(
        trained_on=str(open_loop["trained_on"].iloc[0]),
        tested_on=str(open_loop["tested_on"].iloc[0]),
        size_count=len(sizes),
        scale_rad=float(np.exp(offset)),
        exponent=float(-slope),
        exponent_interval=interval_about(float(-slope), exponents, found[0].source_count),
        r_squared=float(1 - (left**2).sum() / spread) if spread > 0 else 1.0,
    )
