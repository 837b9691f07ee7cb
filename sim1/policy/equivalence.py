"""What a real demonstration is worth: how many generated trajectories make a policy as good (paper, section 4, "equivalence").

The real demonstrations are the largest number that was tried, n, and reach a figure; a curve through the figures of generated
ones says which number m reaches it as well, and the ratio is m / n. Beyond the sizes that were tried nothing is said but "more
than" or "less than".
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from sim1.policy.error_table import error_table, means_of_resamples
from sim1.policy.lessons import GENERATED, REAL
from sim1.policy.success_law import HALF, MIN_SIZES, logistic, resampled
from sim1.stage import random_stream
from sim1.statistics import Interval

RESAMPLES = 500


@dataclass(frozen=True, kw_only=True)
class Worth:
    """Generated trajectories a real demonstration, by one figure."""

    figure: str
    shift: str | None  # of the trials; None: by the action's error
    real_size: int
    real_value: float  # what real demonstrations reach
    ratio: float  # clipped to the sizes that were tried
    bound: str | None  # "more than", "less than": the curve meets that value beyond the sizes that were tried
    interval: Interval | None  # 95 %, bootstrap; its ends stop at the sizes that were tried
    beyond: tuple[bool, bool]  # whether the lower, the upper end of it lies beyond them


def worth(lessons: Mapping[str, Any], open_loop: pd.DataFrame, trials: pd.DataFrame, seed: int) -> list[Worth | str]:
    """By the held-out error on real demonstrations, and by success in each shift; a text says why one is not known.

    `lessons`: of `policy.json`.
    """
    of = {kind: {row["garment"] for row in lesson["splits"]} for kind, lesson in lessons.items()}
    if REAL in of and of[REAL] != of[GENERATED]:
        there, here = (", ".join(sorted(of[kind])) for kind in (REAL, GENERATED))
        return [
            f"real demonstrations are of {there}, generated trajectories of {here}: numbers of them do not compare. They do where all garments were "
            f"demonstrated in reality, as profile paper has it, or in a home of {there} alone in profile study (docs/results.md)"
        ]
    shifts = list(dict.fromkeys(trials["shift"]))
    return [
        by_error(open_loop[open_loop["tested_on"] == REAL], seed),
        *(by_success(trials[trials["shift"] == shift], shift, seed) for shift in shifts),
    ]


def by_error(errors: pd.DataFrame, seed: int) -> Worth | str:
    """From errors of both kinds of policies on the same held-out real demonstrations; these and networks are resampled.

    The interval is that of percentiles: where the curve meets a value is no mean, and may be nowhere.
    """
    figure = "action error on held-out real demonstrations"
    if missing := _missing(errors):
        return f"{figure}: {missing}"
    of = dict(iter(errors.groupby("trained_on")))
    sizes, real = np.array(sorted(of[GENERATED]["size"].unique()), float), int(of[REAL]["size"].max())
    rows = [*(of[GENERATED][of[GENERATED]["size"] == size] for size in sizes), of[REAL][of[REAL]["size"] == real]]
    found = [error_table(one) for one in rows]
    tables, sources = np.stack([one.errors for one in found]), found[0].sources

    def measure(means_rad: np.ndarray) -> tuple[float, float]:
        slope, offset = np.polyfit(np.log(sizes), np.log(means_rad[:-1]), 1)
        level = float(means_rad[-1])
        return level, _crossing(np.log(level), slope, offset, sizes.min(), rises=False)

    again = means_of_resamples(tables, sources, RESAMPLES, random_stream(seed, "worth", "error"))
    level, size = measure(tables.mean(axis=(1, 2)))
    others = [measure(means)[1] for means in again.T] if found[0].source_count > 1 else []
    return _worth(figure, None, real, sizes, level, size, others)


def by_success(trials: pd.DataFrame, shift: str, seed: int) -> Worth | str:
    """From successes of both kinds of policies from the same placements; networks are resampled, and of each its placements.

    Trials of one network succeed or fail together, more or less: as if independent, intervals would come out too narrow.
    """
    figure = f"success, {shift}"
    if missing := _missing(trials):
        return f"{figure}: {missing}"
    counts = trials.assign(of=1).pivot_table(
        index=["garment", "seed", "trial"], columns=["trained_on", "size"], values=["success", "of"], aggfunc="sum"
    )  # a placement belongs to a network's seed and a trial's number (`sim1.policy.trials.run_trial`)
    sizes, real = np.array(sorted(counts["of"][GENERATED]), float), max(counts["of"][REAL])
    wins, tries = (counts[name][GENERATED].to_numpy(float) for name in ("success", "of"))
    real_wins, real_tries = (counts[name][REAL][real].to_numpy(float) for name in ("success", "of"))
    if real_wins.sum() in (0, real_tries.sum()):
        share = "none" if real_wins.sum() == 0 else "all"
        return f"{figure}: {share} of the trials after {real} real demonstrations succeeded; what equals that is not a number"

    def measure(pick: np.ndarray) -> tuple[float, float]:
        real_won, real_of = real_wins[pick].sum(), real_tries[pick].sum()
        won, of = wins[pick].sum(axis=0), tries[pick].sum(axis=0)
        slope, offset = logistic(np.log(sizes), won, of)
        odds = (real_won + HALF) / (real_of - real_won + HALF)  # as in the curve: equals are worth the same
        return float(real_won / real_of), _crossing(float(np.log(odds)), slope, offset, sizes.min(), rises=True)

    networks, rng = list(counts.groupby("seed").indices.values()), random_stream(seed, "worth", shift)
    level, size = measure(np.arange(len(counts)))
    others = [measure(resampled(networks, rng))[1] for _ in range(RESAMPLES)] if len(counts) > 1 else []
    return _worth(figure, shift, real, sizes, level, size, others)


def _missing(rows: pd.DataFrame) -> str | None:
    if not (rows["trained_on"] == REAL).any():
        return "no policy learnt from real demonstrations and was tested"
    sizes = rows[rows["trained_on"] == GENERATED]["size"].nunique()
    if sizes < MIN_SIZES:
        return f"{sizes} sizes of generated trajectories were tested; a curve needs at least {MIN_SIZES}"
    return None


def _crossing(level: float, slope: float, offset: float, smallest: float, *, rises: bool) -> float:
    """Size at which a line over the logarithm of size comes to a level.

    Where more does not help, it is there from the smallest size on (0) or never (infinite).
    """
    if slope == 0 or (slope > 0) != rises:
        there = offset + slope * np.log(smallest)
        return 0.0 if (there >= level) == rises else np.inf
    return float(np.exp(np.clip((level - offset) / slope, -50, 50)))


def _worth(
    figure: str, shift: str | None, real: int, sizes: np.ndarray, level: float, size: float, others: Sequence[float]
) -> Worth:
    """`size`: generated trajectories that equal `real` ones; `others`: the same of resamples, none where there is nothing to draw."""
    low, high = sizes.min(), sizes.max()
    ends = np.quantile(others or [size], [0.025, 0.975], method="nearest")  # never between a number and infinity
    beyond = bool(ends[0] <= low), bool(ends[1] >= high)
    bound = "more than" if size > high else "less than" if size < low else None
    return Worth(
        figure=figure,
        shift=shift,
        real_size=int(real),
        real_value=level,
        ratio=float(np.clip(size, low, high) / real),
        bound=bound,
        interval=Interval(*map(float, np.clip(ends, low, high) / real)) if others else None,
        beyond=beyond,
    )
