"""The report of the scaling curve."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim1.policy.scaling import Point, PowerLaw
from sim1.report import Picture, Section, write_report
from sim1.statistics import describe_share

LEAD = (
    "How the policy gets better with the number of generated trajectories it learns from. All figures are from simulation: "
    "no robot was used."
)
STAND_INS = [
    "Scans of garments that are marked virtual were made by a depth-camera model; the demonstrations behind the generated "
    "trajectories come from a scripted expert, not from a person; the policy is tried in the stand-in "
    "reality, a simulator too: another fabric, air, friction and finer steps than the training data had, but no robot (where there "
    "are recordings of real cloth: in the cell that made the data). A success rate here says nothing yet about a real one.",
]


def write_scaling_page(
    out: Path, points: Sequence[Point], fit: PowerLaw | str, about: Mapping[str, Any], equivalence: Mapping[str, Any]
) -> None:
    """Write `report.html` beside the pictures; `about` is the content of `policy.json`."""
    trials, successes = sum(p.trial_count for p in points), sum(p.success_count for p in points)
    pictures = [out / name for name in ("error.png", "success.png") if (out / name).exists()]
    sections = [
        Section(
            heading="Result",
            paragraphs=[
                *_result(points, fit),
                f"Closed loop, all sizes together: {describe_share(successes, trials)}.",
            ],
            table=[_shown(point) for point in points],
            pictures=[Picture(path=path) for path in pictures],
        ),
        Section(
            heading="How it was measured",
            paragraphs=[
                f"{about['trajectory_count']} trajectories, {about['available_count']} of them for training; "
                f"sizes {about['sizes']}, seeds {about['seeds']}. Smaller training sets lie within larger ones and "
                "hold the garments in equal parts.",
                "Held out: every trajectory that uses one source demonstration per garment (split “source”); other sources "
                "may be shared with training. Split “trajectory”: every trajectory uses every source, so single "
                "trajectories were held out, which is the weaker test. Split “none”: too few to hold any out.",
                "Action error: mean absolute difference between the predicted chunk of joint commands and the recorded one. "
                "Standing still is the error of a policy that does nothing.",
                f"Closed loop: {about['trials']['each']} trials of {about['trial_duration_s']:.1f} s for each of "
                f"{len(about['trials']['models'])} models and each of these garments: "
                f"{', '.join(about['trials']['garments']) or 'none'}. The garment is moved and turned at random first.",
            ],
            table=about["splits"],
        ),
        Section(heading="Worth of a real demonstration", paragraphs=[f"Not computed: {equivalence['reason']}."]),
        Section(heading="What stands in for reality", paragraphs=STAND_INS),
    ]
    write_report(out / "report.html", "Scaling curve", LEAD, sections)


def _result(points: Sequence[Point], fit: PowerLaw | str) -> list[str]:
    if isinstance(fit, str):
        return [f"No curve was fitted: {fit}."]
    low, high = fit.exponent_interval
    words = (
        f"Held-out error of the joint commands against the number n of trajectories: {np.degrees(fit.scale_rad):.3g}° n^(−b) "
        f"with b = {fit.exponent:.2f} (95 % bootstrap interval {low:.2f} to {high:.2f}), R² = {fit.r_squared:.2f}, through "
        f"{len(points)} sizes."
    )
    return [words] if low > 0 else [words, "The interval of b holds zero: an improvement with size is not established."]


def _shown(point: Point) -> dict[str, object]:
    error, interval = point.joint_error_rad, point.joint_error_interval_rad
    return {
        "Trajectories": point.size,
        "Seeds": point.seed_count,
        "Joint error (degrees)": None if error is None else round(float(np.degrees(error)), 3),
        "95 % interval": "–" if interval is None else "{:.3g} to {:.3g}".format(*np.degrees(interval)),
        "Standing still (degrees)": (
            None if point.hold_joint_error_rad is None else round(float(np.degrees(point.hold_joint_error_rad)), 3)
        ),
        "Errors measured": point.held_out_count,
        "Success": describe_share(point.success_count, point.trial_count),
    }
