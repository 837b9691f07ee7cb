"""How success grows with the number of trajectories that were learnt from: a line through the log odds over the logarithm of the number."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sim1.policy.error_table import interval_about
from sim1.policy.lessons import KINDS, NAMES
from sim1.policy.tried import PLACEMENT
from sim1.stage import random_stream
from sim1.statistics import Interval

MIN_SIZES = 3  # a line with two parameters through fewer points would be a drawing
RESAMPLES = 500
HALF = 0.5  # trials of each outcome that are added to every count (Haldane 1956, Anscombe 1956)


@dataclass(frozen=True, kw_only=True)
class SuccessLaw:
    """log(p / (1 - p)) = offset + slope * log(size), by likelihood, p the share of trials that succeed."""

    trained_on: str
    shift: str
    size_count: int
    network_count: int
    trial_count: int
    offset: float
    slope: float
    slope_interval: (
        Interval | None
    )  # 95 %, of networks; of one network, of its placements; None: there is one of these too
    half_size: (
        float | None
    )  # where half of the trials succeed; None: beyond the sizes that were tried, or more does not help

    def at(self, size: np.ndarray) -> np.ndarray:
        """Share of trials that succeed, at sizes (n,)."""
        return 1 / (1 + np.exp(-self.offset - self.slope * np.log(size)))


def fit_success(trials: pd.DataFrame, seed: int) -> list[SuccessLaw | str]:
    """Of every kind of training and shift (rows of `evaluation.parquet`); a text says of which kind there is none, and why."""
    found: list[SuccessLaw | str] = []
    for kind in KINDS:
        own = trials[trials["trained_on"] == kind]
        shifts = list(dict.fromkeys(own["shift"]))
        laws = [fit_success_law(own[own["shift"] == shift], seed) for shift in shifts]
        whys = [f"{NAMES[kind]}: {law}" for law in laws if isinstance(law, str)]
        found += [law for law in laws if isinstance(law, SuccessLaw)] + list(dict.fromkeys(whys))
    return found or ["no trial was run"]


def fit_success_law(trials: pd.DataFrame, seed: int) -> SuccessLaw | str:
    """Of one kind of training in one shift, or the reason why there is none.

    Networks are drawn anew, and of each its placements, as in `sim1.policy.equivalence`; how much the slope varies is taken times
    Student's quantile for as many networks as there are, as for an error (`sim1.policy.error_table.interval_about`).
    """
    sizes = sorted(trials["size"].unique())
    if len(sizes) < MIN_SIZES:
        tried = "1 size was" if len(sizes) == 1 else f"{len(sizes)} sizes were"
        return f"{tried} tried in the closed loop; a fitted curve needs at least {MIN_SIZES}"
    kind, shift = (str(trials[name].iloc[0]) for name in ("trained_on", "shift"))
    counts = trials.assign(of=1).pivot_table(
        index=list(PLACEMENT), columns="size", values=["success", "of"], aggfunc="sum"
    )
    x = np.log(np.array(sizes, float))
    wins, of = (counts[name][sizes].fillna(0).to_numpy(float) for name in ("success", "of"))
    slope, offset = logistic(x, wins.sum(axis=0), of.sum(axis=0))
    networks, rng = list(counts.groupby("seed").indices.values()), random_stream(seed, "success-law", kind, shift)
    units = len(networks) if len(networks) > 1 else len(counts)
    picks = [resampled(networks, rng) for _ in range(RESAMPLES)] if units > 1 else []
    slopes = np.array([logistic(x, wins[pick].sum(axis=0), of[pick].sum(axis=0))[0] for pick in picks])
    half = float(np.exp(np.clip(-offset / slope, -50, 50))) if slope > 0 else np.inf
    return SuccessLaw(
        trained_on=kind,
        shift=shift,
        size_count=len(sizes),
        network_count=len(networks),
        trial_count=len(trials),
        offset=offset,
        slope=slope,
        slope_interval=interval_about(slope, slopes, units) if len(slopes) else None,
        half_size=half if sizes[0] <= half <= sizes[-1] else None,
    )


def logistic(x: np.ndarray, wins: np.ndarray, of: np.ndarray) -> tuple[float, float]:
    """Slope and offset of log odds over x; half a trial of each outcome is added at every size, so that all-or-nothing stays finite."""
    from sklearn.linear_model import LogisticRegression  # takes a second, which who only reads results need not wait

    wins, losses = wins + HALF, of - wins + HALF
    model = LogisticRegression(C=np.inf)
    model.fit(
        np.concatenate([x, x])[:, None],
        np.repeat([1, 0], len(x)),
        sample_weight=np.concatenate([wins, losses]),
    )
    return float(model.coef_[0, 0]), float(model.intercept_[0])


def resampled(clusters: Sequence[np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """Rows of as many clusters as there are, drawn anew, and of each as many rows as it has, drawn anew."""
    drawn = [clusters[place] for place in rng.integers(len(clusters), size=len(clusters))]
    return np.concatenate([rng.choice(rows, size=len(rows)) for rows in drawn])
