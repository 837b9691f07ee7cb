"""The report of the costs."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypedDict

from sim1.policy import paper
from sim1.policy.cost import MADE_BY, PER_TRAJECTORY_STAGES, SHOWN_BY, Prices, Production, Timings
from sim1.policy.counting import read_figures
from sim1.report import Section, write_report

SCHEMA = "sim1.costs/3"
LEAD = (
    "What one trajectory costs: a person at the real robot, the paper's GPU server, and this machine. The first two lines "
    "are the paper's arithmetic; a third stands there only where this project measured its seconds."
)
NOT_MEASURED = (
    "This machine: not measured, because no timings were given, nothing was accepted, or an artifact that every trajectory passes was "
    "made over a process that died, so that nobody knows how long it took."
)


class Way(TypedDict):
    """A way of working, as `costs.json` has it."""

    method: str
    usd_per_day: float
    trajectories_per_day: float
    usd_per_trajectory: float | None
    measured: bool


class PaceFound(TypedDict):
    """`sim1.policy.cost.Pace`, as `costs.json` has it."""

    attempted_s: float
    accepted_s: float
    shown_s: float
    frames_share: float


class Costs(TypedDict):
    """What is read of `costs.json`."""

    attempted_count: int
    accepted_count: int
    pace: PaceFound | None
    not_in_seconds: list[str]
    shown_count: int  # of these in the dataset
    methods: list[Way]


def write_cost_page(out: Path, prices: Prices, timings: Timings) -> None:
    """Write `report.html` beside `costs.json`."""
    found = read_costs(out)
    sections = [
        *result_sections(out),
        Section(heading="How it was reckoned", paragraphs=_method(prices, found)),
        Section(
            heading="Measured seconds",
            paragraphs=[_counts(found), *_left_out(found)] if timings else ["not measured"],
            table=[
                {
                    "Stage": stage,
                    "Seconds": "not known" if None in times.values() else round(sum(times.values()), 1),
                    "Artifacts": len(times),
                    "Every trajectory anew": stage in PER_TRAJECTORY_STAGES,
                }
                for stage, times in timings.items()
                if times
            ],
        ),
    ]
    write_report(out / "report.html", "Cost of a trajectory", LEAD, sections)


def result_sections(artifact: Path) -> list[Section]:
    """What was found, of an artifact of `cost_report`.

    Raises:
        BadInput: the artifact is damaged or of another version.
    """
    found = read_costs(artifact)
    methods = [Production(**{key: item[key] for key in Production.__dataclass_fields__}) for item in found["methods"]]
    here = [
        f"This machine: {_counts(found)[:-1]}; at the measured pace of the stages that every trajectory "
        "passes; its price an hour is an assumption, and its pictures and frame rate are those of the profile, not the paper's."
    ]
    return [
        Section(
            heading="Cost of a trajectory",
            paragraphs=[
                "The first two lines are reckoned from the paper's own prices, beside what it prints; "
                f"relative cost is against the first. Paper: {paper.SOURCE}, table “Comparison of data acquisition efficiency”.",
                *(here if any(item["measured"] for item in found["methods"]) else [NOT_MEASURED]),
                "No trajectory was collected on a real robot by this project; the figures of real collection are the paper's. "
                f"A simulated trajectory is not worth as much as a real one: the paper puts it at about one in {paper.WORTH['in-domain']}.",
            ],
            table=[
                _beside(item, methods[0], printed)
                for item, printed in zip(methods, [paper.COSTS["real"], paper.COSTS["simulation"], None], strict=False)
            ],
        ),
        *([_pace_section(found)] if found["pace"] else []),
    ]


def _pace_section(found: Mapping[str, Any]) -> Section:
    pace, attempted, accepted, shown_count = (
        found[key] for key in ("pace", "attempted_count", "accepted_count", "shown_count")
    )
    rows = (
        (f"attempt, simulated and judged, of {attempted}", pace["attempted_s"]),
        (f"accepted trajectory, rejected attempts included, of {accepted}", pace["accepted_s"]),
        (f"trajectory rendered and written, of {shown_count}", pace["shown_s"]),
        ("accepted trajectory with its frames, in the dataset", pace["accepted_s"] + pace["shown_s"]),
    )
    return Section(
        heading="Seconds of an episode",
        paragraphs=[
            f"Of this machine, the mean over all garments: {', '.join(MADE_BY)}, then {', '.join(SHOWN_BY)}. "
            f"Frames take {100 * pace['frames_share']:.0f} % of the seconds of a trajectory that is accepted and shown. Attempts that were out of the arms' reach, "
            "which cost no simulation, and those disturbed on purpose count as attempts. One measurement, without an interval.",
        ],
        table=[{"Each": name, "Seconds": round(seconds, 2)} for name, seconds in rows],
    )


def _left_out(found: Mapping[str, Any]) -> list[str]:
    """Stages that the seconds do not hold."""
    if not found["not_in_seconds"]:
        return []
    return [
        f"Not in this table, as nothing of them had been made when this page was: {', '.join(found['not_in_seconds'])}. Neither the stages after this one "
        "nor those beside it are waited for."
    ]


def _counts(found: Mapping[str, Any]) -> str:
    return f"{found['attempted_count']} attempts, {found['accepted_count']} accepted trajectories, {found['shown_count']} of them rendered and in the dataset."


def read_costs(artifact: Path) -> dict[str, Any]:
    """Content of `costs.json`.

    Raises:
        BadInput: missing, damaged, or of another version.
    """
    return read_figures(artifact / "costs.json", SCHEMA, "cost_report", Costs)


def _method(prices: Prices, found: Mapping[str, Any]) -> list[str]:
    real, server = prices.real_collection, prices.paper_simulation
    notes = [
        f"Paper, real collection: {real.labour_hours_per_day:g} h at "
        f"${real.labour_usd_per_hour:g} and a ${real.platform_usd:g} platform over "
        f"{real.platform_days:g} days make ${found['methods'][0]['usd_per_day']:.0f} a day. The caption of the paper's table "
        "speaks of two operators; its arithmetic has the wages of one.",
        f"Paper, simulation: {server.gpu_count} GPUs at ${server.gpu_usd_per_hour:g} an hour, "
        f"{server.gpu_minutes_per_trajectory:g} minutes of one GPU per trajectory.",
    ]
    if not any(item["measured"] for item in found["methods"]):
        return [*notes, NOT_MEASURED]
    return [
        *notes,
        f"This machine ({prices.this_machine.description}): {_counts(found)[:-1]}; around the clock at the pace "
        f"of {', '.join(PER_TRAJECTORY_STAGES)}. Rejected candidates are paid for by the accepted ones "
        f"({', '.join(MADE_BY)}), all appearances by the trajectories that are shown ({', '.join(SHOWN_BY)}). "
        "Artifacts that were made side by side count with the seconds of each: alone each would have taken less. "
        f"Its price of ${prices.this_machine.usd_per_hour:g} an hour is an assumption in prices.yaml; short "
        "runs include start-up times that long ones spread out. The work differs too: picture size, frame rate and number "
        "of episodes are those of the profile, not the paper's. Training of filters and policy is not included, nor is the one-time "
        "work listed below.",
    ]


def _beside(item: Production, reference: Production, printed: tuple[float, float, float] | None) -> dict[str, object]:
    """A row in the form of the paper's table "Comparison of data acquisition efficiency"."""
    row = shown(item, reference)
    names = ("Throughput (trajectories/day)", "Unit cost ($/trajectory)", "Relative cost")
    beside: dict[str, object] = {"Method": row["Method"], "Cost per day ($)": row["Cost per day ($)"]}
    for name, figure in zip(names, printed or (None, None, None)):
        beside |= {f"{name} | reckoned": row[name], f"{name} | paper": figure}
    return beside


def shown(item: Production, reference: Production) -> dict[str, object]:
    """What a way of working makes and costs, for a person."""
    unit = item.usd_per_trajectory
    return {
        "Method": item.method,
        "Cost per day ($)": round(item.usd_per_day, 2),
        "Throughput (trajectories/day)": round(item.trajectories_per_day, 1),
        "Unit cost ($/trajectory)": round(unit, 4),
        "Relative cost": round(unit / reference.usd_per_trajectory, 4),
        "Relative throughput": round(item.trajectories_per_day / reference.trajectories_per_day, 2),
    }
