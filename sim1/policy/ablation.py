"""The ablation table: what each variant of the pipeline does to pass rate and success rate, and to success against the base."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim1.clustered_share import Difference
from sim1.policy import paper
from sim1.policy.counting import read_decisions, read_table
from sim1.policy.lessons import GENERATED
from sim1.policy.tried import Tried, compare, count
from sim1.policy.worlds import REALITY, Worlds, worlds_of
from sim1.stage import BadInput, Inputs
from sim1.statistics import Interval, wilson_interval

BASE = "base"
STAGES = ("valid_trajectories", "policy")
SCHEMA = "sim1.ablation/3"
PAPER_METHODS = {  # variant -> the paper's method that it comes nearest to, in the order of its table
    "slicing": "Baseline",
    "decomposition": "+ trajectory decomposition",
    "diffusion": "+ diffusion-based generation",
    "calibrated": "+ deformation-stable solver",
}


class Record(TypedDict):
    """A row of `table.json`, as `as_record` writes it."""

    variant: str
    candidate_count: int
    accepted_count: int
    accepted_and_successful_count: int
    pass_rate: float | None
    pass_rate_ci95: list[float]
    training_size: int | None
    trial_count: int
    success_count: int
    success_rate: float | None
    all_trials: dict[str, Any] | None
    shifts: list[dict[str, Any]]
    worlds: dict[str, list[str]]
    over_base: dict[str, Any] | None
    own_stages: list[str]


class Table(TypedDict):
    """What is read of `table.json`."""

    rows: list[Record]


@dataclass(frozen=True, kw_only=True)
class Row:
    """Counts of one variant."""

    variant: str
    candidate_count: int  # without those disturbed on purpose
    accepted_count: int
    sound_count: int  # accepted by the filters and judged a success in simulation
    training_size: int | None  # trajectories that the policy learnt from; None: no trial was run
    all_trials: Tried | None
    shifts: tuple[Tried, ...]
    worlds: Worlds  # where trials took place
    over_base: (
        Difference | None
    )  # success minus the base's, in the stand-in reality; None: it is the base's policy, or they share no placement there
    own_stages: tuple[str, ...]  # the rest is the base graph's own artifact

    @property
    def pass_interval(self) -> Interval:
        return wilson_interval(self.accepted_count, self.candidate_count)


def variants_of(inputs: Inputs) -> list[str]:
    """Variants named by the inputs (`V/stage`), the base graph first."""
    names = {name.rsplit("/", 1)[0] for name in inputs if "/" in name}
    return [BASE, *sorted(names)]


def count_variant(inputs: Inputs, variant: str) -> Row:
    """Counts of a variant; where it has no artifact of its own, the base's counts are its counts.

    Raises:
        BadInput: an artifact is missing or damaged.
    """
    own = [stage for stage in STAGES if inputs.get(f"{variant}/{stage}")]
    found = {stage: inputs.get(f"{variant}/{stage}" if stage in own else stage) for stage in STAGES}
    if missing := [stage for stage in STAGES if not found[stage]]:
        raise BadInput(f"ablation {variant!r}: no artifact of {', '.join(missing)}; materialize it first")
    decisions = read_decisions(found["valid_trajectories"])
    decisions = decisions[~decisions["perturbed"]]  # disturbed on purpose, for the filters to see failures
    # A variant may end before its policy. Other trajectories never stand beside the base's one: it was not tried, then.
    tried = "policy" in own or "valid_trajectories" not in own
    trials = _largest(found["policy"])
    trials = trials if tried else trials[:0]
    other = variant != BASE and "policy" in own
    return Row(
        variant=variant,
        candidate_count=len(decisions),
        accepted_count=int(decisions["accepted"].sum()),
        sound_count=int((decisions["accepted"] & decisions["success"]).sum()),
        training_size=int(trials["size"].iloc[0]) if len(trials) else None,
        all_trials=count(trials, paper.AVERAGE) if len(trials) else None,
        shifts=tuple(count(runs, shift) for shift, runs in trials.groupby("shift", sort=False)),
        worlds=worlds_of(trials),
        over_base=_over(trials, _largest(inputs["policy"])) if other else None,
        own_stages=tuple(own),
    )


def _over(trials: pd.DataFrame, base: pd.DataFrame) -> Difference | None:
    """In the world that is the same for all variants: each has a simulator of its own, and its trials there are no pairs of another's."""
    own, others = (one[one["world"] == REALITY] for one in (trials, base))
    return compare(own, others, also=["shift"])


def _largest(policies: Mapping[str, Path]) -> pd.DataFrame:
    """Trials after the largest number of generated trajectories; real demonstrations are those of every variant."""
    trials = pd.concat([read_table(path / "evaluation.parquet") for path in policies.values()])
    trials = trials[trials["trained_on"] == GENERATED]
    return trials[trials["size"] == trials["size"].max()]


def as_record(row: Row) -> Record:
    """JSON form, rates as shares of 1."""
    tried = row.all_trials
    return {
        "variant": row.variant,
        "candidate_count": row.candidate_count,
        "accepted_count": row.accepted_count,
        "accepted_and_successful_count": row.sound_count,
        "pass_rate": row.accepted_count / row.candidate_count if row.candidate_count else None,
        "pass_rate_ci95": list(row.pass_interval),
        "training_size": row.training_size,
        "trial_count": tried.trial_count if tried else 0,
        "success_count": tried.success_count if tried else 0,
        "success_rate": tried.success_count / tried.trial_count if tried else None,
        "all_trials": tried and asdict(tried),
        "shifts": [asdict(one) for one in row.shifts],
        "worlds": {world: list(garments) for world, garments in row.worlds.items()},
        "over_base": row.over_base and asdict(row.over_base),
        "own_stages": list(row.own_stages),
    }


def draw_table(rows: Sequence[Row]) -> Figure:
    """Pass rate and success rate per variant, with intervals and counts."""
    figure = Figure(figsize=(7.2, 1.6 + 0.6 * len(rows)), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    places = np.arange(len(rows))
    passed = [(row.accepted_count, row.candidate_count, row.pass_interval) for row in rows]
    tried = [
        (one.success_count, one.trial_count, one.interval) if (one := row.all_trials) else (0, 0, None) for row in rows
    ]
    for ax, title, color, counts in (
        (axes[0], "Pass rate", "#1f6fb4", passed),
        (axes[1], "Success rate", "#b4531f", tried),
    ):
        for place, (some, of, interval) in zip(places, counts, strict=True):
            if of:
                share, bar = 100 * some / of, 100 * np.array(interval)
                ax.barh(place, share, color=color, alpha=0.35, height=0.55)
                ax.errorbar(share, place, xerr=[[share - bar[0]], [bar[1] - share]], fmt="o", color=color, capsize=4)
            ax.text(104, place, f"{some}/{of}" if of else "not tried", va="center", fontsize=9)
        ax.set(xlim=(-2, 102), xlabel="%, with 95 % interval", title=title)
        ax.grid(axis="x", alpha=0.25)
    axes[0].set_yticks(places, [row.variant for row in rows])
    axes[0].invert_yaxis()
    return figure
