"""The report of the costs."""

from collections.abc import Sequence
from pathlib import Path

from sim1.policy.cost import PER_TRAJECTORY_STAGES, Prices, Production, Timings
from sim1.report import Section, write_report

LEAD = (
    "What one trajectory costs: a person at the real robot, the paper's GPU server, and this machine. The first two lines "
    "are the paper's arithmetic; a third stands there only where this project measured its seconds."
)


def write_cost_page(
    out: Path, methods: Sequence[Production], prices: Prices, timings: Timings, trajectory_count: int, measured: bool
) -> None:
    """Write `report.html`; the first of `methods` is what the others are compared with."""
    reference = methods[0]
    notes = [
        f"Paper, real collection: {prices.real_collection.labour_hours_per_day:g} h at "
        f"${prices.real_collection.labour_usd_per_hour:g} and a ${prices.real_collection.platform_usd:g} platform over "
        f"{prices.real_collection.platform_days:g} days make ${reference.usd_per_day:.0f} a day. The caption of the paper's table "
        "speaks of two operators; its arithmetic has the wages of one.",
        f"Paper, simulation: {prices.paper_simulation.gpu_count} GPUs at ${prices.paper_simulation.gpu_usd_per_hour:g} an hour, "
        f"{prices.paper_simulation.gpu_minutes_per_trajectory:g} minutes of one GPU per trajectory.",
    ]
    if measured:
        notes.append(
            f"This machine ({prices.this_machine.description}): {trajectory_count} accepted trajectories, around the clock at the pace "
            f"of {', '.join(PER_TRAJECTORY_STAGES)}; rejected candidates and all appearances are paid for by the accepted "
            f"ones. Its price of ${prices.this_machine.usd_per_hour:g} an hour is an assumption in prices.yaml; short "
            "runs include start-up times that long ones spread out. The work differs too: picture size, frame rate and number "
            "of episodes are those of the profile, not the paper's. Training of filters and policy is not included, nor is the one-time "
            "work listed below."
        )
    else:
        notes.append("This machine: not measured, because no timings were given or nothing was accepted.")
    sections = [
        Section(heading="Comparison", paragraphs=notes, table=[shown(item, reference) for item in methods]),
        Section(
            heading="Measured seconds",
            paragraphs=[f"{trajectory_count} accepted trajectories."] if timings else ["not measured"],
            table=[
                {
                    "Stage": stage,
                    "Seconds": round(sum(times.values()), 1),
                    "Artifacts": len(times),
                    "Every trajectory anew": stage in PER_TRAJECTORY_STAGES,
                }
                for stage, times in timings.items()
            ],
        ),
        Section(
            heading="What stands in for reality",
            paragraphs=[
                "No trajectory was collected on a real robot by this project; the figures of real collection are the paper's. "
                "A simulated trajectory is not worth as much as a real one: the paper puts it at about one fifteenth."
            ],
        ),
    ]
    write_report(out / "report.html", "Cost of a trajectory", LEAD, sections)


def shown(item: Production, reference: Production) -> dict[str, object]:
    """A row in the form of the paper's table "Comparison of data acquisition efficiency"."""
    unit = item.usd_per_trajectory
    return {
        "Method": item.method,
        "Cost per day ($)": round(item.usd_per_day, 2),
        "Throughput (trajectories/day)": round(item.trajectories_per_day, 1),
        "Unit cost ($/trajectory)": round(unit, 4),
        "Relative cost": round(unit / reference.usd_per_trajectory, 4),
        "Relative throughput": round(item.trajectories_per_day / reference.trajectories_per_day, 2),
    }
