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
    one: np.ndarray, two: np.ndarray, one_groups: list[str], two_groups: list[str], rng: np.random.Generator,
    resample_count: int = RESAMPLES,
) -> Auc:  # fmt: skip
    """Held-out AUC of extremely randomised trees (Geurts et al. 2006) that are to tell `one` from `two`.

    Movements of one group are never on both sides of a fold. The interval comes from drawing groups with replacement.

    Args:
        one: (n, d) features.
        two: (m, d)
        one_groups: source demonstration of each movement.
        two_groups: of the other set.
        rng: folds, trees and resamples.
        resample_count: of the bootstrap.
    """
    features, labels = np.concatenate([one, two]), np.repeat([0, 1], [len(one), len(two)])
    groups = np.array([*one_groups, *two_groups])
    scores = np.full(len(labels), np.nan)
    folds = StratifiedGroupKFold(min(FOLDS, len(set(groups))), shuffle=True, random_state=int(rng.integers(2**31)))
    for train, test in folds.split(features, labels, groups):
        trees = ExtraTreesClassifier(
            TREES, min_samples_leaf=2, class_weight="balanced", random_state=int(rng.integers(2**31))
        )
        scores[test] = trees.fit(features[train], labels[train]).predict_proba(features[test])[:, 1]
    value = area_under_roc(labels, scores)
    drawn = [_resampled(labels, scores, groups, rng) for _ in range(resample_count)]
    low, high = np.quantile([auc for auc in drawn if auc is not None] or [value], [0.025, 0.975])
    return Auc(value=value, low=float(low), high=float(high))


def area_under_roc(labels: np.ndarray, scores: np.ndarray) -> float:
    """Chance that one of label 1 scores higher than one of label 0, ties counting half (Mann and Whitney 1947)."""
    ones = int(labels.sum())
    above = rankdata(scores)[labels == 1].sum() - ones * (ones + 1) / 2
    return float(above / (ones * (len(labels) - ones)))


def _resampled(labels: np.ndarray, scores: np.ndarray, groups: np.ndarray, rng: np.random.Generator) -> float | None:
    names = np.unique(groups)
    rows = np.concatenate([np.flatnonzero(groups == name) for name in rng.choice(names, len(names))])
    return area_under_roc(labels[rows], scores[rows]) if len(set(labels[rows])) == 2 else None
