"""The section of the page of all results that says of each claim of the paper whether it was found here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sim1.policy import ablation_page, cost_page
from sim1.policy.claims.evidence import Evidence
from sim1.policy.claims.table import CLAIMS, Asks, Claim
from sim1.policy.claims.verdict import AGREES, DISAGREES, NOT_DECIDED, NOT_RUN, Measured, Missing, verdict
from sim1.policy.curve import read_curve
from sim1.policy.image_trials.measures import read_result
from sim1.report import Section
from sim1.stage import BadInput, Inputs

HEADING = "What the paper claims"
READ: Mapping[str, tuple[str, Callable[[Path], Any]]] = {  # stage -> field of Evidence, and how its figures are read
    "scaling_report": ("curve", read_curve),
    "ablation_report": ("ablation", lambda folder: {row["variant"]: row for row in ablation_page.read_rows(folder)}),
    "image_trials": ("image", lambda folder: read_result(folder)[1]),
    "cost_report": ("costs", cost_page.read_costs),
}
FRAMES = (
    "width",
    "height",
    "samples",
    "variants",
    "rate_hz",
    "cameras",
)  # settings of rendered_episodes: less is cheaper
LARGEST = "paper"  # the profile with the paper's sizes


@dataclass(frozen=True, kw_only=True)
class Plans:
    """Settings, defaults included, of the nodes of every profile: what another run would measure."""

    profile: str = ""  # in force
    settings: Mapping[str, Mapping[str, Mapping[str, Any]]] = field(default_factory=dict)  # profile -> node -> settings
    damaged: Mapping[str, str] = field(default_factory=dict)  # profiles that cannot be read, and why


NODES = tuple(
    dict.fromkeys(
        [*(node for claim in CLAIMS for node in claim.asks.nodes), "rendered_episodes", "candidate_trajectories"]
    )
)


def claims_section(made: Inputs, plans: Plans) -> Section:
    """One row for each claim, with a verdict that follows from the interval of what was measured."""
    known = gather(made, plans)
    rows = [_row(claim, known, plans) for claim in CLAIMS]
    counts = {name: sum(row["Verdict"] == name for row in rows) for name in (AGREES, DISAGREES, NOT_DECIDED, NOT_RUN)}
    return Section(
        heading=HEADING,
        paragraphs=[
            f"Verdicts on {len(rows)} claims: {', '.join(f'“{name}” {count}' for name, count in counts.items())}. Agrees: the whole 95 % interval of what was measured lies in "
            "what agrees with the claim (column); disagrees: all of it lies outside; not decided: it holds both, or there is none. The paper's figures carry no interval; what is let pass is said.",
            "No verdict is about a robot: whatever stands here was measured in simulation, demonstrations are a scripted expert's, what is called real is a stand-in, "
            "and garments and policies are those of the sections below. “Agrees” says that this simulation shows the like, “disagrees” that it does not.",
            *(
                f"Profile {name} cannot be read, what it would measure is not told: {why}."
                for name, why in plans.damaged.items()
            ),
        ],
        table=rows,
    )


def gather(made: Inputs, plans: Plans) -> Evidence:
    """What the reports hold; one that is missing or cannot be read says why."""
    found: dict[str, Any] = {}
    why = {}
    for stage, (name, read) in READ.items():
        folders = made.get(stage)
        if not folders:
            why[stage] = f"stage {stage} was not made"
            continue
        try:
            found[name] = read(folders[""])
        except (BadInput, OSError) as error:
            why[stage] = f"stage {stage} cannot be read: {error}"
    return Evidence(**found, why=why, full_frames=_full_frames(plans))


def _full_frames(plans: Plans) -> bool:
    here, there = (plans.settings.get(name, {}).get("rendered_episodes", {}) for name in (plans.profile, LARGEST))
    sizes = [(one.get(name), other.get(name)) for one, other in [(here, there)] for name in FRAMES]
    return all(one is not None and other is not None and _size(one) >= _size(other) for one, other in sizes)


def _size(value: Any) -> float:
    return float(len(value)) if isinstance(value, list | tuple) else float(value)


def _row(claim: Claim, known: Evidence, plans: Plans) -> dict[str, str]:
    found = claim.find(known)
    said = verdict(found, claim.band)
    return {
        "Claim of the paper": claim.text,
        "Measured here": found.shown if isinstance(found, Measured) else "–",
        "Agrees": claim.band.words,
        "Verdict": said,
        "Why": _why(found, said, claim.asks, plans),
    }


def _why(found: Measured | Missing, said: str, asks: Asks, plans: Plans) -> str:
    if isinstance(found, Missing):
        return _sentences(found.why, _who_runs(asks, plans))
    if said == NOT_DECIDED:
        held = "the interval holds values that agree and values that do not" if found.interval else ""
        return _sentences(held, found.remark, _who_has_more(asks, plans))
    side = "lies in what agrees" if said == AGREES else "lies outside of what agrees"
    return _sentences(f"the whole interval {side}", found.remark)


def _who_runs(asks: Asks, plans: Plans) -> str:
    """Which profile measures it."""
    if not plans.settings:
        return ""
    able = [name for name, nodes in plans.settings.items() if _has(nodes, asks)]
    if plans.profile in able:
        return f"`sim1 run --select {asks.select}` in this profile ({plans.profile}) measures it"
    if not able:
        what = f" with {asks.shift}" if asks.shift else ""
        return f"no profile makes {', '.join(asks.nodes)}{what}"
    return f"measured by profile {' or '.join(able)}: `sim1 run --profile {able[0]} --select {asks.select}`"


def _who_has_more(asks: Asks, plans: Plans) -> str:
    if asks.count is None:
        return ""
    here = _count(plans.settings.get(plans.profile, {}), asks)
    counts = {name: _count(nodes, asks) for name, nodes in plans.settings.items() if _has(nodes, asks)}
    more = [f"{name} {count}" for name, count in counts.items() if count is not None and (here is None or count > here)]
    if not more:
        return ""
    now = "" if here is None else f" (here {here})"
    return f"profiles with more, {asks.count}{now}: {', '.join(more)}"


def _count(nodes: Mapping[str, Mapping[str, Any]], asks: Asks) -> int | None:
    """Of the node itself, or of the base's attempts: `valid_trajectories` has as many as were made."""
    for node in (asks.nodes[0], "candidate_trajectories"):
        if (count := nodes.get(node, {}).get(asks.count)) is not None:
            return count
    return None


def _has(nodes: Mapping[str, Mapping[str, Any]], asks: Asks) -> bool:
    return all(name in nodes for name in asks.nodes) and (
        asks.shift is None or asks.shift in nodes[asks.nodes[0]].get("shifts", ())
    )


def _sentences(*parts: str) -> str:
    return " ".join(f"{part[0].upper()}{part[1:]}." for part in parts if part)
