"""What tested clips come to: precision and recall of each filter, and what became of each class of failure."""

from typing import Any

import numpy as np

from benchmarks.discriminator.turns import Tested
from sim1.clustered_share import clustered_interval, counts_by_cluster
from sim1.statistics import describe_share

FILTERS = {  # what each accepts
    "precise": lambda tested: tested.precise,
    "generous": lambda tested: tested.generous,
    "rules": lambda tested: tested.rules,
    "both": lambda tested: tested.generous & tested.rules,
}


def figures_of(tested: Tested) -> dict[str, Any]:
    """Counts, ROC areas, and precision and recall of each filter, None of those that need rules where there are none, with intervals over families."""
    found: dict[str, Any] = {
        "success_count": int(tested.success.sum()),
        "failure_count": int((~tested.success).sum()),
        "roc_area": [round(area, 4) for area in tested.roc_area],
    }
    for name, accepts in FILTERS.items():
        if tested.rules is None and name in ("rules", "both"):
            found[name] = None
            continue
        taken = accepts(tested)
        found[name] = {
            "precision": _share(tested.success[taken], tested.family[taken]),
            "recall": _share(taken[tested.success], tested.family[tested.success]),
        }
    return found


def accepted_by_class(tested: Tested, verdicts: dict[str, tuple[str | None, float]]) -> dict[str, tuple[int, int]]:
    """Of each class of failure, how many clips the generous threshold accepts, and of how many."""
    classes = np.array([verdicts[name][0] or "folded" for name in tested.name])
    return {
        str(one): (int(tested.generous[classes == one].sum()), int((classes == one).sum()))
        for one in sorted(set(classes))
    }


def _share(wins: np.ndarray, family: np.ndarray) -> dict[str, Any]:
    if not len(wins):
        return {"count": 0, "of": 0, "ci95": [0.0, 1.0]}
    return {
        "count": int(wins.sum()),
        "of": len(wins),
        "ci95": list(clustered_interval(*counts_by_cluster(wins, family))),
    }


def told(filtered: dict[str, Any] | None) -> str:
    """Precision and recall as a cell of a table."""
    if filtered is None:
        return "-"
    return "; ".join(describe_share(one["count"], one["of"], tuple(one["ci95"])) for one in filtered.values())
