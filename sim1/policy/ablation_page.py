"""The report of the ablation."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sim1.clustered_share import Difference
from sim1.policy import paper
from sim1.policy.ablation import BASE, PAPER_METHODS, SCHEMA, Table
from sim1.policy.counting import NOT_RUN, percentage_points, rate, read_figures
from sim1.policy.shift_table import OURS
from sim1.policy.tried import said_of_intervals
from sim1.policy.worlds import said_of_worlds, together
from sim1.report import Picture, Section, write_report
from sim1.statistics import Interval

NO_PAIR = "no placement in common"
LEAD = (
    "What becomes of the generated motions, and of the policy trained on them, when one part of the pipeline is changed. "
    "All figures are from simulation: no robot was used."
)
STAND_INS = [
    "Garment scans may be virtual (made by a depth-camera model), demonstrations come from a scripted expert instead of "
    "a teleoperator (but for garments with commands in data/demonstrations/), and the stand-in reality is a simulator too; where there are recordings of real cloth there is none, and trials are in the cell that made the data.",
    "The paper's columns texture, lighting and viewpoint change pictures or friction; this policy sees joints and garment "
    "keypoints alone, so pictures cannot change its result, and of texture only the friction is left.",
]


def write_ablation_page(out: Path) -> None:
    """Write `report.html` beside `table.json` and the picture."""
    detail = Section(
        heading="What each variant made itself",
        paragraphs=[
            "A variant re-derives only what it changes; where it changes nothing before a figure, the figure is the base's own "
            "(column “own stages”)."
        ],
        table=[_detail(row) for row in read_rows(out)],
    )
    sections = [*result_sections(out), detail, Section(heading="What stands in for reality", paragraphs=STAND_INS)]
    write_report(out / "report.html", "Ablation", LEAD, sections)


def read_rows(artifact: Path) -> list[dict[str, Any]]:
    """Records of the variants.

    Raises:
        BadInput: `table.json` is missing, damaged, or of another version.
    """
    return list(read_figures(artifact / "table.json", SCHEMA, "ablation_report", Table)["rows"])


def result_sections(artifact: Path) -> list[Section]:
    """What was found, of an artifact of `ablation_report`.

    Raises:
        BadInput: the artifact is damaged or of another version.
    """
    rows = {row["variant"]: row for row in read_rows(artifact)}
    few = [name for name, row in rows.items() if row["trial_count"] < paper.TRIALS]
    notes = [
        "Pass rate: generated candidates that the filters accepted (without the attempts that "
        "were disturbed on purpose so that the filters see failures). Success: closed-loop trials "
        "of the policies trained on generated trajectories at the largest size, all seeds together; average: over all trials that were run; texture: friction alone. Percent, with "
        "intervals and counts; those of the pass rate are Wilson's, 95 %, of attempts as independent.",
        "Trajectories: how many the policy learnt from, all that the variant made and did not hold out, or the largest size that was asked for. Variants differ in it too, so that a "
        "difference of success is not of the changed part alone where the numbers differ.",
        "Average minus base: percentage points over trials from the same placements in the same shift, with Newcombe's 95 % interval for pairs from the intervals of either side; "
        "none where the policy is the base's own, and none for trials in the simulator that made the data, as each variant has its own.",
        *said_of_worlds(together([row["worlds"] for row in rows.values()])),
        "Methods of the paper, each with what the one before it has, stand beside the variant that comes nearest; all of these are without named physics, "
        f"which {_titled(BASE)} has.",
        paper.MEANT,
    ]
    if few:
        notes.append(
            f"Fewer than the paper's {paper.TRIALS} trials stand behind the success of {', '.join(few)}: "
            "the intervals, not the percentages, say what is known."
        )
    if len(rows) == 1:
        notes.append("No variant was materialized: the table holds the base graph alone and compares nothing.")
    networks = {_titled(name): row["all_trials"]["network_count"] for name, row in rows.items() if row["all_trials"]}
    if networks:
        notes.append(said_of_intervals(networks))
    order = dict.fromkeys([*PAPER_METHODS, *rows])
    figures = list(dict.fromkeys(figure for row in rows.values() for figure in _rates(row)))
    return [
        Section(
            heading="Ablation",
            paragraphs=notes,
            table=[_beside(variant, rows.get(variant), figures) for variant in order],
            pictures=[Picture(path=path, caption="Counts stand at the right of each bar.")]
            if (path := artifact / "ablation.png").exists()
            else [],
        )
    ]


def _titled(variant: str) -> str:
    return f"{BASE} (all parts)" if variant == BASE else variant


def _beside(variant: str, row: Mapping[str, Any] | None, figures: Sequence[str]) -> dict[str, object]:
    """A row in the form of the paper's table; `row` is None where the variant was not run, `figures` are those that any variant has."""
    method = PAPER_METHODS.get(variant)
    printed = paper.ABLATION[method] if method else {}
    here = _rates(row) if row else {}
    shown: dict[str, object] = {
        "Method | here": _titled(variant),
        "Method | paper": method,
        "Trajectories": row["training_size"] if row else None,
    }
    for figure in (paper.PASS_RATE, *paper.SHIFTS, paper.AVERAGE):
        if figure in figures:
            shown[f"{figure.capitalize()} | here"] = here.get(figure, NOT_RUN)
        shown[f"{figure.capitalize()} | paper"] = printed.get(figure)
    shown["Average minus base (points)"] = _over_base(row)
    return shown


def _over_base(row: Mapping[str, Any] | None) -> str | None:
    """None where the policy is the base's own."""
    if row is None or not row["trial_count"]:
        return NOT_RUN
    if row["variant"] == BASE or "policy" not in row["own_stages"]:
        return None
    found = row["over_base"]
    return percentage_points(Difference(**{**found, "interval": Interval(*found["interval"])})) if found else NO_PAIR


def _rates(row: Mapping[str, Any]) -> dict[str, str]:
    """Pass rate, success by the paper's name of the shift where that was tried, and average."""
    shown = {shift: one for shift, own in OURS.items() for one in row["shifts"] if one["shift"] == own}
    return {
        paper.PASS_RATE: rate(row["accepted_count"], row["candidate_count"]),
        **{shift: _of(one) for shift, one in shown.items()},
        paper.AVERAGE: _of(row["all_trials"]),
    }


def _of(tried: Mapping[str, Any] | None) -> str:
    return rate(tried["success_count"], tried["trial_count"], Interval(*tried["interval"])) if tried else NOT_RUN


def _detail(row: Mapping[str, Any]) -> dict[str, object]:
    return {
        "Variant": _titled(row["variant"]),
        "Accepted": f"{row['accepted_count']} of {row['candidate_count']}",
        "Accepted and folded": row["accepted_and_successful_count"],
        "Succeeded": f"{row['success_count']} of {row['trial_count']}",
        "Own stages": "all" if row["variant"] == BASE else ", ".join(row["own_stages"]) or "none",
    }
