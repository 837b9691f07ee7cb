"""How far apart two sets of feature vectors are, as wholes."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import sqrtm
from sklearn.covariance import ledoit_wolf


class Mmd(NamedTuple):
    """Squared maximum mean discrepancy and the share of random relabellings that reach it."""

    value: float
    p_value: float


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


def mmd(one: np.ndarray, two: np.ndarray, permutation_count: int, rng: np.random.Generator) -> Mmd:
    """Unbiased estimate with a Gaussian kernel as wide as the median distance, and a permutation test.

    Source: Gretton et al. 2012, equation 3 and section 5.

    Args:
        one: (n, d) features in comparable units, n > 1.
        two: (m, d), m > 1.
        permutation_count: random relabellings.
        rng: draws them.
    """
    both = np.concatenate([one, two])
    squared = ((both[:, None] - both[None]) ** 2).sum(axis=-1)
    kernel = np.exp(-squared / (2 * np.median(squared[np.triu_indices(len(both), 1)])))
    value = _unbiased(kernel, np.arange(len(one)), len(both))
    count = sum(
        _unbiased(kernel, rng.permutation(len(both))[: len(one)], len(both)) >= value for _ in range(permutation_count)
    )
    return Mmd(value=value, p_value=(count + 1) / (permutation_count + 1))


def _unbiased(kernel: np.ndarray, first: np.ndarray, count: int) -> float:
    mask = np.zeros(count, bool)
    mask[first] = True
    n, m = mask.sum(), count - mask.sum()
    within = kernel[np.ix_(mask, mask)], kernel[np.ix_(~mask, ~mask)]
    inner = [(part.sum() - np.trace(part)) / (size * (size - 1)) for part, size in zip(within, (n, m), strict=True)]
    return float(inner[0] + inner[1] - 2 * kernel[np.ix_(mask, ~mask)].mean())
