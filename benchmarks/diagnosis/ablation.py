"""What each part of the diagnosis is worth: right answers to the same bundles with a part left out, see `left_out.py`."""

from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median

from benchmarks.diagnosis.asked import each_once
from benchmarks.diagnosis.left_out import COLUMNS, with_parts_left_out
from sim1.proof.answers import Answers, kind_of
from sim1.proof.outcome import is_right

KINDS = {"single": "one effect", "null": "nothing", "outside": "outside the table", "several": "two effects"}


def ablation(folders: list[Path], out: Path, tell: Callable[[str], None]) -> str:
    """A Markdown table: what every variant says of each case (folders as `asked.py` knows them); right ones are counted by kind, weak single effects aside.

    Its last line has the median of the seconds that a variant took. Writes OUT/CASE.json after each case, and asks no case twice.
    """
    rows, right, seconds = [], [], []
    for answers, found in each_once(folders, out, "with one part left out at a time", with_parts_left_out, tell):
        concealed, kind = tuple(effect.name for effect in answers.effects), kind_of(answers)
        good = {label: is_right(kind, concealed, found[label][0], tuple(found[label][1])) for label in COLUMNS}
        cells = {label: " ".join((found[label][0], " + ".join(found[label][1]))).strip() for label in COLUMNS}
        wrong = "weak, not counted" if _weak(answers) else "wrong"
        rows.append(
            _row(
                " + ".join(concealed) or "nothing",
                {label: cell if good[label] else f"{cell} ({wrong})" for label, cell in cells.items()},
            )
        )
        if not _weak(answers):
            right.append((kind, good))
        seconds.append({label: found[label][2] for label in COLUMNS})
    counted = [(f"right, {KINDS[kind]}", [good for its, good in right if its == kind]) for kind in KINDS]
    counted.append(("right, all", [good for _, good in right]))
    return "\n".join(
        [
            _row("concealed", {label: label for label in COLUMNS}),
            "| --- " * (len(COLUMNS) + 1) + "|",
            *rows,
            *(_row(name, _counts(good)) for name, good in counted if good),
            _row("seconds, median", {label: f"{median(one[label] for one in seconds):.0f}" for label in COLUMNS}),
        ]
    )


def _weak(answers: Answers) -> bool:
    """Whether it is a single effect below what can be detected: of it silence is no fault, and a campaign does not count it."""
    return kind_of(answers) == "single" and answers.case.strength == "weak"


def _counts(good: list[dict[str, bool]]) -> dict[str, str]:
    return {label: f"{sum(one[label] for one in good)} of {len(good)}" for label in COLUMNS}


def _row(name: str, cells: Mapping[str, str]) -> str:
    return f"| {name} | {' | '.join(cells[label] for label in COLUMNS)} |"
