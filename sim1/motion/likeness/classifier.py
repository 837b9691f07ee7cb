"""A classifier that tries to tell two sets of movements apart: what it cannot tell is alike as far as it can see."""

from typing import NamedTuple

import numpy as np
from scipy.stats import rankdata
from sklearn.ensemble import ExtraTreesClassifier
from sklearn.model_selection import StratifiedGroupKFold

FOLDS = 5
TREES = 100
RESAMPLES = 1000


class Auc(NamedTuple):
    """Area under the ROC curve on held-out movements, with its 95 % bootstrap interval; 0.5 is a guess, 1 certainty."""

    value: float
    low: float
    high: float


def told_apart(
    one: np.ndarray, two: np.ndarray, one_families: np.ndarray, two_families: np.ndarray, rng: np.random.Generator,
    resample_count: int = RESAMPLES,
) -> Auc:  # fmt: skip
    """Held-out AUC of extremely randomised trees (Geurts et al. 2006) that are to tell `one` from `two`.

    Movements of one family are never on both sides of a fold. The interval comes from drawing families with replacement.

    Args:
        one: (n, d) features, of two families at least.
        two: (m, d), likewise.
        one_families: (n,) number of the family of each movement.
        two_families: (m,)
        rng: folds, trees and resamples.
        resample_count: of the bootstrap.
    """
    features, labels = np.concatenate([one, two]), np.repeat([0, 1], [len(one), len(two)])
    families = np.concatenate([one_families, two_families])
    scores = np.full(len(labels), np.nan)
    folds = StratifiedGroupKFold(min(FOLDS, len(set(families))), shuffle=True, random_state=int(rng.integers(2**31)))
    for train, test in folds.split(features, labels, families):
        trees = ExtraTreesClassifier(
            TREES, min_samples_leaf=2, class_weight="balanced", random_state=int(rng.integers(2**31))
        )
        scores[test] = trees.fit(features[train], labels[train]).predict_proba(features[test])[:, 1]
    value = area_under_roc(labels, scores)
    drawn = [_resampled(labels, scores, families, rng) for _ in range(resample_count)]
    low, high = np.quantile([auc for auc in drawn if auc is not None] or [value], [0.025, 0.975])
    return Auc(value=value, low=float(low), high=float(high))


def area_under_roc(labels: np.ndarray, scores: np.ndarray) -> float:
    """Chance that one of label 1 scores higher than one of label 0, ties counting half (Mann and Whitney 1947)."""
    ones = int(labels.sum())
    above = rankdata(scores)[labels == 1].sum() - ones * (ones + 1) / 2
    return float(above / (ones * (len(labels) - ones)))


def _resampled(labels: np.ndarray, scores: np.ndarray, families: np.ndarray, rng: np.random.Generator) -> float | None:
    names = np.unique(families)
    rows = np.concatenate([np.flatnonzero(families == name) for name in rng.choice(names, len(names))])
    return area_under_roc(labels[rows], scores[rows]) if len(set(labels[rows])) == 2 else None
