"""A threshold, what it does to clips that had no say in it, and whether that is evidence enough to decide by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from sklearn.metrics import roc_auc_score

from sim1.statistics import describe_share, wilson_interval

LEAST_RECALL = 0.5  # a threshold that throws away more than half of the good clips decides nothing


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a threshold does to some clips."""

    accepted: int
    accepted_success: int
    success_count: int
    failure_count: int

    @property
    def recall(self) -> float:
        """Share of the successes that is accepted; 0 where there is none."""
        return self.accepted_success / self.success_count if self.success_count else 0.0


def outcome(score: np.ndarray, success: np.ndarray, threshold: float) -> Outcome:
    """Of clips with scores (n,) that are successes (n,) or not."""
    taken = score >= threshold
    good = int(success.sum())
    return Outcome(
        accepted=int(taken.sum()),
        accepted_success=int((taken & success).sum()),
        success_count=good,
        failure_count=len(success) - good,
    )


def threshold_for(score: np.ndarray, success: np.ndarray, precision: float) -> float | None:
    """Lowest threshold whose precision is at least the wanted one: most recall. None where no threshold has it.

    It lies half-way between the lowest score that it accepts and the next lower one.
    """
    levels = np.sort(np.unique(score))
    for level, below in zip(levels, np.append(0.0, levels)[:-1], strict=True):
        found = outcome(score, success, level)
        if found.accepted_success and found.accepted_success / found.accepted >= precision:
            return float(level + below) / 2
    return None


def figures(score: np.ndarray, success: np.ndarray, threshold: float | None) -> dict[str, object]:
    """Counts, ROC area, and precision and recall at the threshold with Wilson intervals."""
    found: dict[str, object] = {"success_count": int(success.sum()), "failure_count": int((~success).sum())}
    if len(set(success.tolist())) == 2:
        found["roc_area"] = float(roc_auc_score(success, score))
    if threshold is not None:
        at = outcome(score, success, threshold)
        found |= {
            "accepted_count": at.accepted,
            "precision": at.accepted_success / at.accepted if at.accepted else None,
            "precision_ci95": list(wilson_interval(at.accepted_success, at.accepted)),
            "recall": at.recall,
            "recall_ci95": list(wilson_interval(at.accepted_success, at.success_count)),
        }
    return found


def doubt(test: Outcome, wanted: float, least: int) -> str:
    """Why clips that had no say in network and threshold do not support that it decides; empty where they do.

    Args:
        test: what became of them.
        wanted: precision that the threshold was chosen for.
        least: clips of the rarer outcome.
    """
    count, rarer = test.success_count + test.failure_count, min(test.success_count, test.failure_count)
    if rarer < least:
        return (
            f"too few test clips: {count}, {rarer} of the rarer outcome; "
            f"fewer than {least} are no evidence, even if all of them are told rightly"
        )
    low, high = wilson_interval(test.accepted_success, test.accepted)
    said = f"successes among the test clips that it accepts: {describe_share(test.accepted_success, test.accepted)}"
    if low <= test.success_count / count:
        return f"{said}, not surely more than accepting all gives, {test.success_count / count:.0%}"
    if high < wanted:
        return f"{said}, wanted {wanted:.0%}"
    if test.recall < LEAST_RECALL:
        return f"it keeps only {test.recall:.0%} of the {test.success_count} successes among the test clips"
    return ""
