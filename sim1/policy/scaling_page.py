"""The report of the scaling curves."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim1.policy import paper
from sim1.policy.counting import NOT_RUN
from sim1.policy.curve import read_curve
from sim1.policy.equivalence import Worth
from sim1.policy.error_table import said_of_errors
from sim1.policy.lessons import NAMES, REAL
from sim1.policy.scaling import Point, PowerLaw
from sim1.policy.shift_table import OURS, shift_section, task_section
from sim1.policy.success_law import SuccessLaw
from sim1.policy.tried import said_of_intervals
from sim1.policy.worlds import said_of_worlds
from sim1.report import Picture, Section, write_report
from sim1.statistics import describe_share

LEAD = (
    "How the policy gets better with the number of trajectories it learns from, and what a real demonstration is worth. All figures "
    "are from simulation: no robot was used, and what is called real is a stand-in."
)
STAND_INS = [
    "Scans of garments that are marked virtual were made by a depth-camera model; the demonstrations behind the generated "
    "trajectories, made in the simulator, come from a scripted expert, not from a person (but for garments with commands in data/demonstrations/); real demonstrations are the expert's in the stand-in "
    "reality: a simulator too, with another fabric, effects of its own, other friction, finer steps and a finer mesh than the training data had, but no robot (where there are recordings of real cloth there is none, and "
    "trials are in the cell that made the data). A success rate here says nothing yet about a real one.",
]
RATIO, PAPER_RATIO = "Generated for one real | here", "Generated for one real | paper"
SHIFTS = {
    "in-domain": "laid down within {laid_mm:.0f} mm of where it was demonstrated",
    "spatial": "moved by up to {shift_mm:.0f} mm and turned by up to {turn_deg:.0f} degrees",
    "friction": "in-domain, friction of all contacts taken times {factors} in turn: what another texture changes for a policy that sees no pictures",
}


def write_scaling_page(out: Path, about: Mapping[str, Any]) -> None:
    """Write `report.html` beside `curve.json` and the pictures; `about` is the content of `policy.json`."""
    lessons = about["lessons"]
    sections = [
        *result_sections(out),
        Section(
            heading="How it was measured",
            paragraphs=[
                *[
                    f"{NAMES[kind]}: {lesson['available_count']} to train on, {lesson['held_out_count']} held out; "
                    f"sizes {lesson['sizes']}, seeds {about['seeds']}."
                    for kind, lesson in lessons.items()
                ],
                *([] if REAL in lessons else [f"No real demonstrations: {about['no_real_demonstrations']}."]),
                "Every seed draws trajectories of its own to train on, smaller training sets within larger ones; where a size is all there are, "
                "all seeds learn from the same ones. Garments take turns in them while their trajectories last, and each set shows all "
                "garments that there are of its kind: sizes below their number were raised to it.",
                "Held out of the generated: every trajectory that uses one of the held-out source demonstrations of its garment (split “source”), "
                "as many as bring the share near to what is asked for; other sources may be shared with training. Split “trajectory”: every trajectory uses every source, so single "
                "trajectories were held out, which is the weaker test. Split “none”: too few to hold any out.",
                "Action error: mean absolute difference between the predicted chunk of joint commands and the recorded one. "
                "Standing still is the error of a policy that does nothing.",
                _trials(about),
            ],
            table=[{"of": NAMES[kind], **row} for kind, lesson in lessons.items() for row in lesson["splits"]],
        ),
    ]
    write_report(out / "report.html", "Scaling curves", LEAD, sections)


def result_sections(artifact: Path) -> list[Section]:
    """What was found, of an artifact of `scaling_report`.

    Raises:
        BadInput: the artifact is damaged or of another version.
    """
    curve = read_curve(artifact)
    tried = [one for point in curve.points for one in point.trials]
    trials, successes = sum(one.trial_count for one in tried), sum(one.success_count for one in tried)
    networks = {f"{p.size} {NAMES[p.trained_on]}": p.all_trials.network_count for p in curve.points if p.all_trials}
    pictures = [artifact / name for name in ("success.png", "error.png") if (artifact / name).exists()]
    return [
        Section(
            heading="Scaling curves",
            paragraphs=[
                *_laws(curve.fits),
                *map(_success, curve.success_fits),
                *_errors(curve.points),
                f"Closed loop, all together: {f'{successes} of {trials}' if trials else 'none tried'}. The paper draws its curves and prints no figures of them.",
                *said_of_worlds(curve.worlds),
                *([said_of_intervals(networks)] if tried else []),
                *STAND_INS,
            ],
            table=[_shown(point) for point in curve.points],
            pictures=[Picture(path=path) for path in pictures],
        ),
        shift_section(curve.points, curve.over_real),
        task_section(curve.tasks),
        _worth_section(curve.worths, {one.shift for one in tried}),
    ]


def _worth_section(worths: Sequence[Worth | str], tried: set[str]) -> Section:
    known = [one for one in worths if isinstance(one, Worth)]
    shifts = {OURS.get(shift): shift for shift in paper.WORTH}  # ours -> the paper's
    missing = {own: shift for own, shift in shifts.items() if own not in {one.shift for one in known}}
    return Section(
        heading="Worth of a real demonstration",
        paragraphs=[
            "Generated trajectories that make a policy as good as one real demonstration, at the largest number of these that "
            "was tried; real ones are a stand-in here. The paper's are of a real robot; beside friction "
            "stands its figure for other textures, which change friction too.",
            *[f"Not known: {one}." for one in worths if isinstance(one, str)],
        ],
        table=[
            *(_worth(one, shifts.get(one.shift)) for one in known),
            *(
                {
                    "By": f"success, {own}",
                    RATIO: "not known" if own in tried else NOT_RUN,
                    PAPER_RATIO: paper.WORTH[shift],
                }
                for own, shift in missing.items()
            ),
        ],
    )


def _trials(about: Mapping[str, Any]) -> str:
    trials = about["trials"]
    size = {
        "laid_mm": 1e3 * trials["laid_m"],
        "shift_mm": 1e3 * trials["shift_m"],
        "turn_deg": np.degrees(trials["turn_rad"]),
        "factors": " and ".join(map(str, trials["friction_factors"])),
    }
    times = ", ".join(
        f"{garment} {limit['duration_s']:.1f} s (by {NAMES[limit['longest_of']]})"
        for garment, limit in trials["time_limits"].items()
    )
    drivers = {tuple(key) for keys in trials["models"].values() for key in keys}
    meant = "; ".join(f"{shift}: {SHIFTS[shift].format(**size)}" for shift in trials["shifts"])
    return (
        f"Closed loop: {trials['each']} trials for each of {len(drivers)} models, each "
        f"of these garments that it has learnt from: {', '.join(trials['garments']) or 'none'}, and each shift; networks of one seed meet the same placements, those of another seed others. {meant}. "
        f"A trial lasts {trials['time_factor']:g} times the longest trajectory of its garment: {times or 'none'}."
    )


def _laws(fits: Sequence[PowerLaw]) -> list[str]:
    if not fits:
        return ["No curve was fitted to errors: that needs three sizes and something held out."]
    words = []
    for fit in fits:
        told = (
            f"Trained on {NAMES[fit.trained_on]}, tested on held-out {NAMES[fit.tested_on]}: error of the joint commands against the "
            f"number n of trajectories {np.degrees(fit.scale_rad):.3g}° n^(−b) with b = {fit.exponent:.2f} ({_of(fit)}), "
            f"R² = {fit.r_squared:.2f}, through {fit.size_count} sizes."
        )
        known = fit.exponent_interval is not None and fit.exponent_interval.low > 0
        words.append(told if known else f"{told} An improvement with size is not established.")
    return words


def _success(law: SuccessLaw | str) -> str:
    if isinstance(law, str):
        return f"No curve was fitted to success: {law}."
    who = f"{law.network_count} networks" if law.network_count > 1 else "one network's placements"
    interval = (
        f"95 % bootstrap interval {law.slope_interval.low:.2f} to {law.slope_interval.high:.2f}, {who}"
        if law.slope_interval
        else "one trial a size: no interval"
    )
    half = "" if law.half_size is None else f" Half of them succeed at n = {law.half_size:.3g}."
    told = (
        f"Success after n {NAMES[law.trained_on]}, {law.shift}: p / (1 − p) = exp({law.offset:.2f}) · n^b with b = {law.slope:.2f} ({interval}), "
        f"through {law.size_count} sizes, {law.trial_count} trials.{half}"
    )
    known = law.slope_interval is not None and law.slope_interval.low > 0
    return told if known else f"{told} An improvement with size is not established."


def _errors(points: Sequence[Point]) -> list[str]:
    """What intervals of errors, and of what is fitted to them, hold; nothing where no error was measured."""
    sources = {NAMES[error.tested_on]: error.source_count for point in points for error in point.errors}
    return [said_of_errors(sources)] if sources else []


def _of(fit: PowerLaw) -> str:
    if fit.exponent_interval is None:
        return "one held-out demonstration: no interval"
    return "95 % bootstrap interval {:.2f} to {:.2f}".format(*fit.exponent_interval)


def _shown(point: Point) -> dict[str, object]:
    row: dict[str, object] = {
        "Trained on": NAMES[point.trained_on],
        "Trajectories": point.size,
        "Seeds": point.seed_count,
    }
    for error in point.errors:
        interval = "({:.3g} to {:.3g}), ".format(*np.degrees(error.interval_rad)) if error.interval_rad else ""
        row[f"Error on held-out {error.tested_on} (degrees)"] = (
            f"{np.degrees(error.joint_error_rad):.3g} {interval}n = {error.count}, "
            f"demonstrations: {error.source_count}; "
            f"standing still {np.degrees(error.hold_joint_error_rad):.3g}"
        )
    for tried in point.trials:
        row[f"Success, {tried.shift}"] = describe_share(tried.success_count, tried.trial_count, tried.interval)
    return row


def _worth(one: Worth, shift: str | None) -> dict[str, object]:
    unit = 100 * one.real_value if one.shift else np.degrees(one.real_value)
    return {
        "By": one.figure,
        RATIO: f"{one.bound + ' ' if one.bound else ''}{one.ratio:.3g}",
        PAPER_RATIO: paper.WORTH.get(shift) if shift else None,
        "95 % interval, here": _ends(one),
        "Real demonstrations": one.real_size,
        "They reach": f"{unit:.3g}{' %' if one.shift else '°'}",
    }


def _ends(one: Worth) -> str:
    """The interval; an end beyond the sizes that were tried is a bound."""
    if one.interval is None:
        return "–"
    low, high = (f"{end:.3g}" for end in one.interval)
    below, above = one.beyond
    return f"{'at most ' if below else ''}{low} to {'at least ' if above else ''}{high}"
