"""The page of an image policy."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim1.policy.error_table import said_of_errors
from sim1.policy.image.measures import ALL_TITLES, BLANK, DATASET, Mean, Point, of_pictures
from sim1.policy.image.shifts import IN_DOMAIN, TITLES
from sim1.report import Picture, Section, write_report

# What is said of fewer would rest on a handful of motions; of one demonstration there is no interval at all.
MIN_TRAJECTORIES, MIN_SOURCES = 8, 2
LEAD = (
    "A policy that sees rendered pictures and joint angles, tried on trajectories that it has not seen, and on the same "
    "trajectories with one thing in the picture changed. All figures are from simulation with a scripted expert: no robot was used."
)
STAND_INS = [
    "Pictures are rendered, cloth and arms are simulated, the demonstrations behind the trajectories are a scripted "
    "expert's (a person's where data/demonstrations/ has commands for the garment), and garments that are marked virtual were never scanned. What is measured is how near the predicted commands "
    "come to the recorded ones, not whether a garment gets folded: the policy does not drive here (it does in stage image_trials). Nothing here is a success rate.",
    "The paper's column “texture” changes friction with the fabric; here the motion is the recorded one and only the picture "
    "changes. Its column “spatial” moves the garment: every generated trajectory has its garment moved already.",
]


def write_page(out: Path, points: Sequence[Point], about: Mapping[str, Any]) -> None:
    """Write `report.html` beside the pictures; `about` is the content of `image_policy.json`."""
    looks = _picture(out / "looks.png", "Every row is one moment of a held-out trajectory.")
    sections = [
        result_section("Result", out, points),
        *([Section(heading="Grippers", table=[_grippers(point) for point in points])] if points else []),
        *([Section(heading="What was changed", paragraphs=[_changes(about)], pictures=looks)] if looks else []),
        Section(
            heading="How it was measured",
            paragraphs=_method(about),
            table=about["splits"],
        ),
        Section(
            heading="The policy",
            paragraphs=[
                f"{about['title']} (lerobot's “{about['type']}”, size {about['size']}): {about['parameter_count']:,} "
                f"parameters, {about['training']['steps']} steps of {about['training']['batch']} frames on "
                f"{about['device']}. It sees {', '.join(about['inputs'])}, not the garment's keypoints, and predicts "
                f"{about['chunk_frames']} commands at {about['rate_hz']} Hz. Networks: {len(about['networks'])}, which differ in "
                "their first weights and in the order of the frames. Loss: mean of the first and of the last tenth of the steps."
            ],
            table=[_network(network) for network in about["networks"]],
            pictures=_picture(out / "loss.png"),
        ),
        Section(heading="What stands in for reality", paragraphs=STAND_INS),
    ]
    write_report(out / "report.html", "Image policy", LEAD, sections)


def result_section(heading: str, artifact: Path, points: Sequence[Point], notes: Sequence[str] = ()) -> Section:
    """What was found."""
    return Section(
        heading=heading,
        paragraphs=[*_result(points), *_shifts(points), *_intervals(points), *notes],
        table=[_joints(point) for point in points],
        pictures=_picture(
            artifact / "errors.png",
            "Error by what the pictures show; trajectories of one held-out demonstration alone have no interval.",
        ),
    )


def _picture(path: Path, caption: str = "") -> list[Picture]:
    return [Picture(path=path, caption=caption)] if path.exists() else []


def _result(points: Sequence[Point]) -> list[str]:
    plain = of_pictures(points, DATASET)
    if plain is None:
        return ["No trajectory was held out, so nothing was measured: one trajectory of a garment is too few to split."]
    said = [
        f"Held-out error of the joint commands {np.degrees(plain.joint_rad.value):.2f}° against "
        f"{np.degrees(plain.hold_joint_rad):.2f}° of standing still, {plain.trajectory_count} held-out trajectories in "
        f"{plain.clip_count} clips; held-out demonstrations that they come from: {plain.source_count}."
    ]
    if _are_few(plain):
        said.append(f"Whether it is better than standing still is not told: {_too_few(plain)}.")
    elif plain.joint_rad.value >= plain.hold_joint_rad:
        said.append("That is no better than standing still: the policy has learnt nothing of use yet.")
    return said


def _shifts(points: Sequence[Point]) -> list[str]:
    """What a changed picture does, as far as the intervals carry; nothing where few trajectories made them."""
    shifts = [point for point in points if point.pictures not in (DATASET, IN_DOMAIN, BLANK)]
    blank = of_pictures(points, BLANK)
    if blank is None:
        return [] if not points else ["No trajectory was rendered anew (setting `shifted_trajectories`)."]
    if _are_few(blank):
        return [
            f"Whether the policy looks at its pictures, and which change of them does harm, is not told: {_too_few(blank)}."
        ]
    looks = _grows(blank.joint_change_rad)
    worse = {
        what: [ALL_TITLES[point.pictures] for point in shifts if _grows(change(point))]
        for what, change in (("joint", lambda p: p.joint_change_rad), ("gripper", lambda p: p.openness_change))
    }
    return [
        "With one colour in place of its picture the policy does worse: it looks. How much of that is that such a picture is unlike "
        "any that it has seen is not told apart."
        if looks
        else "That the policy does worse with one colour in place of its picture is not established: where it hardly looks, that a "
        "change of the picture does no harm is no robustness.",
        "".join(
            f"The {what} error grows, beyond its interval, with: {', '.join(names)}. "
            for what, names in worse.items()
            if names
        )
        + ("Otherwise" if any(worse.values()) else "In no picture with one thing changed")
        + " an error greater than in a look of training "
        + ("is not established." if any(worse.values()) else "is established."),
    ]


def _intervals(points: Sequence[Point]) -> list[str]:
    sources = {ALL_TITLES[point.pictures]: point.source_count for point in points}
    return [said_of_errors(sources)] if sources else []


def _are_few(point: Point) -> bool:
    return point.trajectory_count < MIN_TRAJECTORIES or point.source_count < MIN_SOURCES


def _too_few(point: Point) -> str:
    """Why nothing is said of the intervals in the table."""
    of = "1 trajectory" if point.trajectory_count == 1 else f"{point.trajectory_count} trajectories"
    by = "1 demonstration" if point.source_count == 1 else f"{point.source_count} demonstrations"
    return f"{of} of {by} are too few to tell, {MIN_TRAJECTORIES} of {MIN_SOURCES} are the least"


def _grows(change: Mean | None) -> bool:
    return change is not None and change.interval is not None and change.interval.low > 0


def _changes(about: Mapping[str, Any]) -> str:
    offsets = ", ".join(f"{TITLES[shift]} {deg:+g}°" for shift, deg in sorted(about["elevation_offset_deg"].items()))
    return (
        f"Looks: {', '.join(TITLES.values())}. A look of training is that of a training clip of the same garment, drawn at "
        "random for each held-out trajectory; all others differ from it in one thing. Other lighting replaces lamps and sky by those of a light of another name, another texture replaces the fabric by a made-up one and "
        f"the table with it, the head camera is turned about the table's middle to {about['viewpoint_deg']:g}° of elevation beyond all that training "
        f"has seen ({offsets or 'no views'}, from where the scene has it). "
        "Wrist cameras, where there are any, do not move with it. What is new comes from the distribution that training looks "
        "come from. All these were rendered and encoded as the dataset was."
    )


def _method(about: Mapping[str, Any]) -> list[str]:
    every = about["evaluate_every"]
    return [
        f"{about['train_count']} training trajectories in {about['train_clips']} clips, {about['held_out_count']} held out. "
        "Split “source”: every trajectory that uses one of the held-out source demonstrations was held out; other sources may be shared "
        "with training. Split “trajectory”: every trajectory uses every source, so single trajectories were held out, which is "
        "the weaker test. Split “none”: too few to hold any out. Normalisation comes from the training part alone.",
        f"Error: mean absolute difference between the predicted chunk of {about['chunk_frames']} commands and the recorded "
        f"one, the last command held at the end, given the recorded picture and state, "
        f"{'in every frame' if every == 1 else f'every {every} frames'}. "
        "Standing still commands the arms to stay where they are. All appearances of a trajectory are averaged first; "
        "changes are paired by trajectory and network.",
    ]


def _network(network: Mapping[str, Any]) -> dict[str, object]:
    error_rad = network["joint_error_rad"]
    return {
        "Network seed": network["seed"],
        "Loss, first": f"{network['loss']['first']:.3g}",
        "Loss, last": f"{network['loss']['last']:.3g}",
        "Held-out joint error (degrees)": "–" if error_rad is None else f"{np.degrees(error_rad):.2f}",
    }


def _joints(point: Point) -> dict[str, object]:
    return {
        "Pictures": ALL_TITLES[point.pictures],
        "Trajectories (clips)": f"{point.trajectory_count} ({point.clip_count})",
        "Demonstrations": point.source_count,
        "Joint error (degrees)": _number(point.joint_rad, ".2f", np.degrees(1.0)),
        "Against a look of training": _number(point.joint_change_rad, "+.2f", np.degrees(1.0)),
        "Standing still (degrees)": f"{np.degrees(point.hold_joint_rad):.2f}",
    }


def _grippers(point: Point) -> dict[str, object]:
    return {
        "Pictures": ALL_TITLES[point.pictures],
        "Openness error (0 to 1)": _number(point.openness, ".3f"),
        "Against a look of training": _number(point.openness_change, "+.3f"),
        "Standing still": f"{point.hold_openness:.3f}",
    }


def _number(mean: Mean | None, form: str, factor: float = 1.0) -> str:
    if mean is None:
        return "–"
    value = format(factor * mean.value, form)
    if mean.interval is None:
        return value
    low, high = (format(factor * limit, form) for limit in mean.interval)
    return f"{value} ({low} to {high})"
