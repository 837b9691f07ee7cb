"""Shares over trials that hang together, as those of one network do: effective number of trials, interval, paired difference."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from sim1.statistics import Interval, difference_interval, wilson_interval

UPPER = 0.975  # quantile at the upper end of a 95 % interval


@dataclass(frozen=True, kw_only=True)
class Difference:
    """The first share minus the second, over pairs of trials."""

    pair_count: int
    value: float
    interval: Interval  # 95 %


def effective_count(successes: Sequence[int] | np.ndarray, trials: Sequence[int] | np.ndarray) -> float:
    """Number of independent trials that would tell the share as well as all these, never more than there are.

    p (1 - p) / v, times the squared ratio of Student's quantiles for n trials and for k clusters, with v the variance of the
    share between clusters. Clusters of one trial each are independent trials. Where v is zero, as it is where none or all of the
    trials succeed, every trial counts: that takes such clusters for alike, and where they differ much the interval is too narrow.
    Of one cluster every trial counts too: what another one would do is not in it.
    Source: E. L. Korn, B. I. Graubard, Surv. Methodol. 24 (1998) 193.

    Args:
        successes: of each cluster, shape (k,).
        trials: of each cluster, shape (k,), at least one each.
    """
    won, of = np.asarray(successes, float), np.asarray(trials, float)
    clusters, count = len(of), int(of.sum())
    if clusters in (1, count):
        return float(count)
    share = won.sum() / count
    between = clusters / (clusters - 1) * ((won - share * of) ** 2).sum() / count**2
    if np.isclose(between, 0.0, rtol=0.0, atol=1e-15):
        return float(count)
    few = (stdtrit(count - 1, UPPER) / stdtrit(clusters - 1, UPPER)) ** 2
    return float(min(count, share * (1 - share) / between * few))


def clustered_interval(successes: Sequence[int] | np.ndarray, trials: Sequence[int] | np.ndarray) -> Interval:
    """Wilson's 95 % interval of the share, from the effective number of trials; (0, 1) when nothing was tried.

    Args:
        successes: of each cluster, shape (k,).
        trials: of each cluster, shape (k,), at least one each.
    """
    count = sum(trials)
    if not count:
        return wilson_interval(0, 0)
    effective = effective_count(successes, trials)
    return wilson_interval(effective * float(sum(successes) / count), effective)


def counts_by_cluster(wins: np.ndarray, clusters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Successes (k,) and trials (k,) of each cluster, from outcomes (n,) and labels (n,)."""
    _, place = np.unique(clusters, return_inverse=True)
    return np.bincount(place, weights=wins).astype(int), np.bincount(place)


def paired_difference(first: np.ndarray, second: np.ndarray, clusters: np.ndarray) -> Difference:
    """Of two shares over the same pairs, with Newcombe's 95 % interval from the clustered limits of either.

    The correlation of the shares is that of paired outcomes (phi, with his correction for continuity), less where clusters
    differ: that clusters of the two sides were alike in pairs is not assumed.
    Source: R. G. Newcombe, Stat. Med. 17 (1998) 2635, method 10.

    Args:
        first: outcomes, shape (n,), n at least 1.
        second: outcomes of the same pairs, shape (n,).
        clusters: label of each pair, shape (n,): those of one label hang together.
    """
    sides = [np.asarray(side, bool) for side in (first, second)]
    pairs = len(sides[0])
    counts = [counts_by_cluster(side, clusters) for side in sides]
    shared = np.sqrt(np.prod([effective_count(*each) for each in counts])) / pairs
    one, other = (float(side.mean()) for side in sides)
    limits = [clustered_interval(*each) for each in counts]
    return Difference(
        pair_count=pairs,
        value=one - other,
        interval=difference_interval((one, limits[0]), (other, limits[1]), float(shared * _phi(*sides))),
    )


def _phi(first: np.ndarray, second: np.ndarray) -> float:
    """Correlation of paired outcomes; a positive one is corrected for continuity, zero where one side never changes."""
    margins = np.prod([float(side.sum()) for side in (first, ~first, second, ~second)])
    if not margins:
        return 0.0
    excess = float(
        (first & second).sum() * (~first & ~second).sum() - (first & ~second).sum() * (~first & second).sum()
    )
    if excess > 0:
        excess = max(0.0, excess - len(first) / 2)
    return excess / float(np.sqrt(margins))
