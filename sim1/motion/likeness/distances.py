"""How far apart two sets of feature vectors are, as wholes."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import sqrtm
from sklearn.covariance import ledoit_wolf


class Mmd(NamedTuple):
    """Squared maximum mean discrepancy and the share of exchanges within families that reach it, None where none was asked for."""

    value: float
    p_value: float | None


def standardised(one: np.ndarray, two: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both sets (n, d) and (m, d) in units of their pooled spread, about their pooled mean; constant columns left out."""
    both = np.concatenate([one, two])
    spread = both.std(axis=0)
    varies = spread > 1e-9
    middle = both.mean(axis=0)[varies]
    return (one[:, varies] - middle) / spread[varies], (two[:, varies] - middle) / spread[varies]


def frechet_distance(one: np.ndarray, two: np.ndarray) -> float:
    """Squared Fréchet distance of the Gaussians of two sets (n, d) and (m, d), per dimension.

    Covariances are shrunk (Ledoit and Wolf 2004), since there are fewer samples than numbers in a covariance.
    Source: Dowson and Landau 1982; Heusel et al. 2017.
    """
    a, b = ledoit_wolf(one)[0], ledoit_wolf(two)[0]
    # The trace of (a b)^(1/2) is that of a symmetric matrix's root, which has no imaginary rounding.
    root = sqrtm(a).real
    cross = np.sqrt(np.clip(np.linalg.eigvalsh(root @ b @ root), 0, None)).sum()
    shift = one.mean(axis=0) - two.mean(axis=0)
    return max(float(shift @ shift + np.trace(a) + np.trace(b) - 2 * cross), 0.0) / one.shape[1]


def mmd(
    one: np.ndarray, two: np.ndarray, one_families: np.ndarray, two_families: np.ndarray, exchange_count: int, rng: np.random.Generator
) -> Mmd:  # fmt: skip
    """Unbiased estimate with a Gaussian kernel as wide as the median distance, and a permutation test, both of whole families.

    Movements of a family depend on each other: they are averaged, so that families count alike, and only pairs of different
    families enter the estimate. Where there is no difference, what is of `one` and what is of `two` in a family could be
    exchanged: the test draws such exchanges, or goes through all of them where they are no more than `exchange_count`.
    Source: Gretton et al. 2012, equation 3 and section 5; Good 2005 for exchanges within matched pairs.

    Args:
        one: (n, d) features in comparable units, of two families at least.
        two: (m, d), likewise.
        one_families: (n,) number of the family of each.
        two_families: (m,)
        exchange_count: of the test; 0 for no test.
        rng: draws them.
    """
    both = np.concatenate([one, two])
    squared = ((both[:, None] - both[None]) ** 2).sum(axis=-1)
    kernel = np.exp(-squared / (2 * np.median(squared[np.triu_indices(len(both), 1)])))
    ones, twos = np.unique(one_families), np.unique(two_families)
    family = np.concatenate([ones, twos])
    member = np.zeros((len(family), len(both)))
    member[: len(ones), : len(one)] = ones[:, None] == one_families
    member[len(ones) :, len(one) :] = twos[:, None] == two_families
    member /= member.sum(axis=1, keepdims=True)
    means = member @ kernel @ member.T
    first = np.arange(len(family)) < len(ones)
    value = _across(means, family, first)
    if not exchange_count:
        return Mmd(value=value, p_value=None)
    matched = np.intersect1d(ones, twos)
    every = 2 ** len(matched)
    if every <= exchange_count:
        exchanges = (np.arange(every)[:, None] >> np.arange(len(matched)) & 1).astype(bool)
    else:  # as it is, and random ones
        exchanges = np.concatenate(
            [np.zeros((1, len(matched)), bool), rng.random((exchange_count, len(matched))) < 0.5]
        )
    reached = [_across(means, family, first ^ np.isin(family, matched[some])) >= value - 1e-12 for some in exchanges]
    return Mmd(value=value, p_value=float(np.mean(reached)))


def _across(means: np.ndarray, family: np.ndarray, first: np.ndarray) -> float:
    """Squared discrepancy between the blocks (b,) that are `first` and the others, from the mean kernels (b, b) of different families."""
    apart = family[:, None] != family
    within = [means[np.ix_(side, side)][apart[np.ix_(side, side)]].mean() for side in (first, ~first)]
    return float(sum(within) - 2 * means[np.ix_(first, ~first)][apart[np.ix_(first, ~first)]].mean())
