"""The paper's claims: its words and figures, what would agree with them, who measures it.

Figures are those of `sim1.policy.paper`. What agrees is written beside the verdict, as the paper prints no interval.
"""

from dataclasses import dataclass

from sim1.policy import paper
from sim1.policy.ablation import PAPER_METHODS
from sim1.policy.claims.cost_evidence import reckoned_per_day, throughput, unit_cost
from sim1.policy.claims.evidence import Finder
from sim1.policy.claims.success_evidence import (
    generated_over_real,
    image_success,
    state_success,
    success_slope,
    worth_of_a_real_demonstration,
)
from sim1.policy.claims.variant_evidence import base_over, pass_over, pass_rate, policy_over, policy_success
from sim1.policy.claims.verdict import (
    Band,
    about,
    at_least,
    at_most,
    more_than_nothing,
    near,
    pass_share,
    success_of,
    success_share,
)
from sim1.policy.shift_table import OURS


@dataclass(frozen=True, kw_only=True)
class Asks:
    """What a profile has to have, so that its run measures the claim, and what then to run."""

    nodes: tuple[str, ...]  # of the graph: `policy`, or `slicing/valid_trajectories`
    select: str  # the stage to run
    shift: str | None = None  # among the setting `shifts` of the first node
    count: str | None = None  # setting of the first node: more of it narrow the interval


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One row."""

    text: str  # with the paper's figure
    band: Band  # what agrees
    find: Finder
    asks: Asks


FACTOR = 2.0  # "approximately 15" (section "Scaling analysis")
TRIALS_OF_ALL = paper.TRIALS * len(paper.SHIFTS)
_BY_VARIANT = {paper_method: variant for variant, paper_method in PAPER_METHODS.items()}
_FULL = _BY_VARIANT[paper.FULL]
_SCALING = {"select": "scaling_report", "count": "trial_count"}
_IMAGE = {"nodes": ("image_trials",), "select": "image_trials", "count": "trial_count"}


def _ablation(stage: str, *variants: str) -> Asks:
    count = "candidate_count" if stage == "valid_trajectories" else "trial_count"
    return Asks(nodes=tuple(f"{name}/{stage}" for name in variants), select="ablation_report", count=count)


CLAIMS: tuple[Claim, ...] = (
    *(
        Claim(
            text=f"One real demonstration is worth {figure} generated trajectories, {shift}",
            band=about(figure, FACTOR),
            find=worth_of_a_real_demonstration(shift),
            asks=Asks(nodes=("policy",), shift=OURS[shift], **_SCALING),
        )
        for shift, figure in paper.WORTH.items()
    ),
    Claim(
        text="Success rises with the number of generated trajectories (curves without printed figures), in-domain",
        band=more_than_nothing(),
        find=success_slope("in-domain"),
        asks=Asks(nodes=("policy",), shift="in-domain", **_SCALING),
    ),
    *(
        Claim(
            text=f"Generated trajectories alone, {shift}: {paper.ABLATION[paper.FULL][shift]} % succeed (policy that sees pictures)",
            band=success_of(paper.ABLATION[paper.FULL][shift], paper.TRIALS),
            find=image_success(shift),
            asks=Asks(shift=shift, **_IMAGE),
        )
        for shift in paper.SHIFTS
    ),
    *(
        Claim(
            text=f"Generated trajectories alone, average: {figure} % succeed ({where}; policy that sees pictures)",
            band=success_of(figure, TRIALS_OF_ALL),
            find=image_success(paper.AVERAGE),
            asks=Asks(shift=paper.SHIFTS[-1], **_IMAGE),
        )
        for figure, where in (
            (paper.ABLATION[paper.FULL][paper.AVERAGE], "ablation table"),
            (paper.ZERO_SHOT, "abstract"),
        )
    ),
    *(
        Claim(
            text=f"Policy that knows the keypoints, {shift}{', here friction' if own != shift else ''}: the same {paper.ABLATION[paper.FULL][shift]} % (the paper's sees pictures)",
            band=success_of(paper.ABLATION[paper.FULL][shift], paper.TRIALS),
            find=state_success(shift),
            asks=Asks(nodes=("policy",), shift=own, **_SCALING),
        )
        for shift, own in OURS.items()
    ),
    *(
        Claim(
            text=f"Generated trajectories teach more than real demonstrations, {shift}: {figure:+d} points",
            band=more_than_nothing(),
            find=generated_over_real(shift),
            asks=Asks(nodes=("policy",), shift=OURS.get(shift, shift), **_SCALING),
        )
        for shift, figure in paper.GENERATED_OVER_REAL.items()
    ),
    Claim(
        text=f"Generated motion passes more often than slicing: {paper.ABLATION[paper.FULL][paper.PASS_RATE]} against {paper.ABLATION['Baseline'][paper.PASS_RATE]} %",
        band=more_than_nothing(),
        find=pass_over(_FULL, _BY_VARIANT["Baseline"]),
        asks=_ablation("valid_trajectories", _FULL, _BY_VARIANT["Baseline"]),
    ),
    *(
        Claim(
            text=f"Ablation, {method}: {printed[paper.PASS_RATE]} % of the attempts pass",
            band=pass_share(printed[paper.PASS_RATE]),
            find=pass_rate(_BY_VARIANT[method]),
            asks=_ablation("valid_trajectories", _BY_VARIANT[method]),
        )
        for method, printed in paper.ABLATION.items()
    ),
    *(
        Claim(
            text=f"Ablation, {method}: its policy succeeds in {printed[paper.AVERAGE]} %",
            band=success_share(printed[paper.AVERAGE], TRIALS_OF_ALL),
            find=policy_success(_BY_VARIANT[method]),
            asks=_ablation("policy", _BY_VARIANT[method]),
        )
        for method, printed in paper.ABLATION.items()
        if paper.AVERAGE in printed
    ),
    Claim(
        text=f"Alignment of the simulator decides: the deformation-stable solver adds {paper.SOLVER_ADDS} points of success",
        band=more_than_nothing(),
        find=policy_over(_FULL, _BY_VARIANT["+ diffusion-based generation"]),
        asks=_ablation("policy", _FULL, _BY_VARIANT["+ diffusion-based generation"]),
    ),
    Claim(
        text="Alignment of the simulator decides: a calibrated simulator teaches more than one that knows the data sheet alone (no figure)",
        band=more_than_nothing(),
        find=policy_over("calibrated", "uncalibrated"),
        asks=_ablation("policy", "calibrated", "uncalibrated"),
    ),
    Claim(
        text="This project's own, not the paper's: a simulator with the physics that was named teaches more than one that is calibrated without",
        band=more_than_nothing(),
        find=base_over("calibrated"),
        asks=_ablation("policy", "calibrated"),
    ),
    *(
        Claim(
            text=f"A day of {name} costs ${paper.COST_PER_DAY[key]}",
            band=near(paper.COST_PER_DAY[key], 0.5, " $"),
            find=reckoned_per_day(at),
            asks=Asks(nodes=("cost_report",), select="cost_report"),
        )
        for at, (key, name) in enumerate((("real", "real collection"), ("simulation", "simulation")))
    ),
    Claim(
        text=f"Simulation makes {paper.COSTS['simulation'][0]} trajectories a day",
        band=at_least(paper.COSTS["simulation"][0], "a day"),
        find=throughput,
        asks=Asks(nodes=("cost_report",), select="cost_report"),
    ),
    Claim(
        text=f"A generated trajectory costs ${paper.COSTS['simulation'][1]:.2f}, a real one ${paper.COSTS['real'][1]:.2f}",
        band=at_most(paper.COSTS["simulation"][1], "$"),
        find=unit_cost,
        asks=Asks(nodes=("cost_report",), select="cost_report"),
    ),
)
