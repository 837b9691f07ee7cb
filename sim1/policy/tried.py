"""Closed-loop trials counted and compared: success with an interval that heeds which trials hang together, and paired differences."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sim1.clustered_share import Difference, clustered_interval, counts_by_cluster, paired_difference
from sim1.statistics import Interval

PLACEMENT = ("garment", "seed", "trial")  # trials that agree in these begin in one state (`sim1.policy.trials.drive`)


@dataclass(frozen=True, kw_only=True)
class Tried:
    """Trials in one setting."""

    shift: str
    trial_count: int
    success_count: int
    network_count: int
    interval: Interval  # 95 %, clustered: of one network that of its trials


def count(trials: pd.DataFrame, shift: str) -> Tried:
    """Of rows of `evaluation.parquet`, all taken together; `shift` names them."""
    wins, of = counts_by_cluster(trials["success"].to_numpy(bool), _clusters(trials))
    return Tried(
        shift=shift,
        trial_count=len(trials),
        success_count=int(wins.sum()),
        network_count=int(trials["seed"].nunique()),
        interval=clustered_interval(wins, of),
    )


def compare(own: pd.DataFrame, others: pd.DataFrame, also: Sequence[str] = ()) -> Difference | None:
    """Success of `own` trials minus that of `others` over pairs from one placement, that agree in columns `also` too.

    None where there is no pair. Trials without a partner are left out.

    Raises:
        pandas.errors.MergeError: several rows of one side are of one placement.
    """
    keys = [*PLACEMENT, *also]
    both = own[[*keys, "success"]].merge(others[[*keys, "success"]], on=keys, validate="one_to_one")
    if both.empty:
        return None
    return paired_difference(*(both[name].to_numpy(bool) for name in ("success_x", "success_y")), _clusters(both))


def _clusters(trials: pd.DataFrame) -> np.ndarray:
    """Labels (n,): trials of one network hang together; of one network alone, those that begin in one state do."""
    if trials["seed"].nunique() > 1:
        return trials["seed"].to_numpy()
    return trials.groupby(list(PLACEMENT)).ngroup().to_numpy()


def said_of_intervals(networks: Mapping[str, int]) -> str:
    """What the intervals on a page hold. `networks`: how many drove, by what they are called there."""
    said = (
        "Intervals are 95 %: trials of one network hang together, and count as many independent ones as the spread between networks says "
        "(Korn and Graubard's effective number, in Wilson's interval)."
    )
    alone = [name for name, number in networks.items() if number == 1]
    if not alone:
        return said
    whose = "everywhere here" if len(alone) == len(networks) else f"here: {', '.join(alone)}"
    return f"{said} One network alone drove {whose}; such an interval is that of its trials, and what another network would do is not in it."
