"""The page about likeness: one table, and what each line of it means."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sim1.report import Picture, Section, write_report

LEAD = (
    "How like the demonstrations is the motion that is generated from them? Generated are the ways between interactions; the "
    "interactions themselves are demonstrated ones. Nothing was simulated for this: whole paths were planned, arms included, "
    "with the garment where it was placed."
)
STAND_IN = (
    "Where no commands lie in data/demonstrations/, the demonstrator is a scripted expert, a stand-in for a person: its ways are "
    "minimum-jerk curves of the joints without any tremor, so regular that small errors of a sampler give it away. Likeness to people was "
    "not measured."
)
COLUMNS = {
    "demonstrations": "Demonstrations", "diffusion": "Diffusion", "straight": "Straight lines",
    "minimum_jerk": "Minimum jerk", "slicing": "Slicing",
}  # fmt: skip
# Figure of the record, line of the table, meaning.
LINES = (
    ("join", "Joins", "Where two parts meet, position, velocity and acceleration of the tools make a step. 95 % of the joins stay "
     "below this many times the step below which 95 % of all frames of the demonstrations stay; the worst of the three. The "
     "demonstrations' own column is taken at the frames where they were cut: cuts lie where hands slow down or start."),
    ("jerk_share", "Jerk", "Dimensionless jerk (duration cubed over peak speed squared times the integral of squared jerk; Hogan "
     "and Sternad 2009), against the demonstrations' median at the same place of the task; median. 1 is as smooth as they are."),
    ("sparc", "Spectral arc length", "SPARC (Balasubramanian et al. 2015) of the speed, cut off at 10 Hz, threshold 0.05: nearer "
     "to 0 is smoother, and it does not depend on size or duration. Median."),
    ("path_share", "Length of the way", "Length over straight line, against the demonstrations' median at the same place of the "
     "task; median."),
    ("peaks", "Speed peaks", "Peaks of the speed in a transition, with a prominence of a tenth of the highest speed; mean."),
    ("frechet", "Fréchet distance", "Squared distance of the Gaussians through both sets of features, per feature, in units of their "
     "spread. Demonstrations: random halves of them, with the range of 90 % of the splits."),
    ("mmd", "Mean discrepancy", "Squared maximum mean discrepancy, Gaussian kernel. A demonstration and all that is made of it are one "
     "family, and so are demonstrations that a path mixes; p is the share of exchanges of demonstrated and generated within whole "
     "families that reach it: below 0.05 the sets differ."),
    ("auc", "Told apart", "Area under the ROC curve of a classifier that is to tell generated from demonstrated ones of families it was "
     "not trained on, with a 95 % interval from drawing families; 0.5 is a guess, 1 certainty. Demonstrations: two random halves of "
     "them told apart, which is what chance looks like with so few."),
    ("nearest", "Nearest demonstration", "Distance of each shape to the nearest demonstrated one, in lengths of its straight line; "
     "median, smallest, largest. Demonstrations: to the nearest other one."),
    ("copies", "Copies", "Transitions that are nearer to a demonstrated one than a tenth of the smallest distance between two of "
     "those."),
)  # fmt: skip


def write_page(out: Path, record: Mapping[str, Any]) -> None:
    """Write `report.html` beside the picture; `record` is the content of `likeness.json`."""
    counts, method = record["counts"], record["method"]
    names = [name for name in COLUMNS if name in record["figures"]]
    limits = {row["figure"]: row for row in record["limits"][method]}
    refused = {name: row["refused"] for name, row in counts["plans"].items() if row["refused"]}
    sections = [
        Section(
            heading="Result",
            paragraphs=[
                f"{counts['demonstrations']} demonstrations with {counts['demonstrated_transitions']} transitions; "
                f"{counts['plans'][method]['planned']} paths planned by each method from the same draws, with the garment "
                "where the demonstrations found it, so that what differs is the motion and not the place.",
                *([f"Draws that could not be planned: {refused}."] if refused else []),
                f"Limits are for {COLUMNS[method].lower()}. A dash was not asked; “not measured” says how much was missing.",
            ],
            table=[_line(name, title, names, record, limits.get(name)) for name, title, _ in LINES],
            pictures=[Picture(path=out / "likeness.png", caption="Speed of the tool that goes further.")],
        ),
        Section(heading="What stands in for reality", paragraphs=[STAND_IN]),
        Section(heading="What the lines mean", table=[{"Figure": title, "Meaning": text} for _, title, text in LINES]),
        Section(
            heading="Joins in full",
            paragraphs=["Steps at joins over common steps, of the tools [m] and of the joints [rad]."],
            table=[
                {"Step of": f"{what} {order}"}
                | {COLUMNS[name]: record["figures"][name][f"join_{what}_{order}"]["value"] for name in names}
                for what in ("tool", "joint")
                for order in ("position", "velocity", "acceleration")
            ],
        ),
    ]
    if record["telling"].get(method):
        sections.append(
            Section(
                heading=f"What gives {COLUMNS[method].lower()} away",
                paragraphs=["The features that tell generated from demonstrated transitions best, each on its own."],
                table=[
                    {
                        "Transition": row["transition"],
                        "Feature": row["feature"],
                        "Told apart": round(row["auc"], 2),
                        "Demonstrated": f"{row['demonstrated_mean']:.3g} ± {row['demonstrated_std']:.2g}",
                        "Generated": f"{row['generated_mean']:.3g} ± {row['generated_std']:.2g}",
                    }
                    for row in record["telling"][method]
                ],
            )
        )
    if record["moved_figures"]:
        sections.append(
            Section(
                heading="With the garment elsewhere",
                paragraphs=["The same with the garment moved and turned at random, which no demonstration was."],
                table=[
                    {"Figure": title}
                    | {COLUMNS[name]: _cell(row.get(figure)) for name, row in record["moved_figures"].items()}
                    for figure, title, _ in LINES[:5]
                ],
            )
        )
    write_report(out / "report.html", f"Likeness of generated motion: {record['garment']}", LEAD, sections)


def _line(
    figure: str, title: str, names: list[str], record: Mapping[str, Any], limit: Mapping[str, Any] | None
) -> dict[str, str]:
    cells = {COLUMNS[name]: _cell(record["figures"][name].get(figure)) for name in names}
    met = {True: "yes", False: "no", None: "not measured"}[limit["met"]] if limit else "–"
    return {"Figure": title} | cells | {"Limit": limit["words"] if limit else "–", "Met": met}


def _cell(figure: Mapping[str, Any] | None) -> str:
    if figure is None:
        return "–"
    if "value" not in figure:
        return f"not measured: {figure['not_measured']}"
    words = f"{figure['value']:.3g}"
    if "low" in figure:
        words += f" ({figure['low']:.2g} to {figure['high']:.2g})"
    return words + (f", p = {figure['p_value']:.2g}" if "p_value" in figure else "")
