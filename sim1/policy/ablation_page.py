"""The report of the ablation."""

from collections.abc import Sequence
from pathlib import Path

from sim1.policy.ablation import BASE, PAPER_ROWS, Row
from sim1.report import Picture, Section, write_report
from sim1.statistics import wilson_interval

LEAD = (
    "What becomes of the generated motions, and of the policy trained on them, when one part of the pipeline is changed. "
    "All figures are from simulation: no robot was used."
)


def write_ablation_page(out: Path, rows: Sequence[Row]) -> None:
    """Write `report.html` beside the picture `ablation.png`."""
    few = [row.variant for row in rows if row.trial_count < 30]
    notes = [
        "Pass rate: generated candidates that the filters accepted (without the attempts that "
        "were disturbed on purpose so that the filters see failures). Success rate: closed-loop trials, in the stand-in reality (the simulated cell with a concealed fabric, air, friction and finer steps) "
        "of the policies trained on generated trajectories at the largest size, all seeds together; shifts as in the scaling report. "
        "Intervals are 95 % Wilson intervals.",
        "A variant re-derives only what it changes; where it changes nothing before a figure, the figure is the base's own "
        "(column “own stages”).",
    ]
    if few:
        notes.append(
            f"Fewer than the paper's 30 trials stand behind the success rates of {', '.join(few)}: "
            "the intervals, not the percentages, say what is known."
        )
    if len(rows) == 1:
        notes.append("No variant was materialized: the table holds the base graph alone and compares nothing.")
    stand_ins = [
        "Garment scans may be virtual (made by a depth-camera model), demonstrations come from a scripted expert instead of "
        "a teleoperator, and the stand-in reality is a simulator too; where there are recordings of real cloth, trials are in the cell that made the data.",
        "The paper's columns texture, lighting and viewpoint change pictures or friction; this policy sees joints and garment "
        "keypoints alone, so pictures cannot change its result, and of texture only the friction is left.",
    ]
    sections = [
        Section(
            heading="Result",
            paragraphs=notes,
            table=[_shown(row) for row in rows],
            pictures=[Picture(path=out / "ablation.png", caption="Counts stand at the right of each bar.")],
        ),
        Section(
            heading="The paper's table, for comparison",
            paragraphs=[
                "Real robot, 30 trials per configuration, an image policy (π0.5); not the same quantity as above."
            ],
            table=PAPER_ROWS,
        ),
        Section(heading="What stands in for reality", paragraphs=stand_ins),
    ]
    write_report(out / "report.html", "Ablation", LEAD, sections)


def _shown(row: Row) -> dict[str, object]:
    return {
        "Method": row.variant if row.variant != BASE else "base (all parts)",
        "Pass rate (%)": _rate(row.accepted_count, row.candidate_count, row.pass_interval),
        "Accepted": f"{row.accepted_count} of {row.candidate_count}",
        "Accepted and folded": row.sound_count,
        **{f"{name.capitalize()} (%)": _rate(some, of, wilson_interval(some, of)) for name, some, of in row.shifts},
        "Average (%)": _rate(row.success_count, row.trial_count, row.success_interval),
        "Succeeded": f"{row.success_count} of {row.trial_count}",
        "Own stages": ", ".join(row.own_stages) or "none" if row.variant != BASE else "all",
    }


def _rate(count: int, total: int, interval: tuple[float, float]) -> str:
    if not total:
        return "not tried"
    return f"{100 * count / total:.0f} ({100 * interval[0]:.0f} to {100 * interval[1]:.0f})"
