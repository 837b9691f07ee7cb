"""The page of an image policy's trials."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim1.policy import paper
from sim1.policy.counting import NOT_RUN, percentage_points, rate, together
from sim1.policy.image_trials.looks import SHIFTS
from sim1.policy.image_trials.measures import IN_DOMAIN, ShiftTried, by_shift, of_all
from sim1.policy.lessons import NAMES
from sim1.policy.tried import said_of_intervals
from sim1.report import Picture, Section, write_report

LEAD = (
    "A policy that sees rendered pictures and joint angles drives the arms of a simulated cell, as it was trained and with "
    "one thing changed. All figures are from simulation with a scripted expert: no robot was used."
)
STAND_INS = [
    "Pictures are rendered while the cloth is simulated, in the stand-in reality, with another fabric, effects of its own, other friction, finer steps and a finer mesh than the training data had "
    "(where there are recordings of real cloth: in the cell that made the data). Demonstrations are a scripted expert's (a person's "
    "where data/demonstrations/ has commands for the garment). The cameras stand where the scene has them and the pictures come without delay and "
    "without a video codec's loss, which training pictures have. A success rate here says nothing yet about a real one.",
]
STRIPS = (
    "What the policy's first camera saw when it planned: the first success and the first failure of each class, in the order of the trials; nobody "
    "chose them."
)


def write_page(out: Path, tried: Sequence[ShiftTried], about: Mapping[str, Any]) -> None:
    """Write `report.html` beside the pictures; `about` is the content of `image_trials.json`."""
    garments = [_row(one, {"Garment": one.garment, "Shift": one.shift}) for one in tried if one.garment]
    sections = [
        result_section("Result", out, tried, about),
        *([Section(heading="By garment", table=garments)] if garments else []),
        strip_section(out),
        Section(heading="What was changed", paragraphs=_changes(about)),
        Section(heading="How it was measured", paragraphs=_method(about)),
        Section(heading="What stands in for reality", paragraphs=STAND_INS),
    ]
    write_report(out / "report.html", "Image policy in the closed loop", LEAD, sections)


def result_section(heading: str, artifact: Path, tried: Sequence[ShiftTried], about: Mapping[str, Any]) -> Section:
    """Who drove, and success by shift with the paper's figures."""
    found = {one.shift: one for one in by_shift(tried)}
    every = of_all(tried)
    picture = artifact / "success.png"
    return Section(
        heading=heading,
        paragraphs=[
            f"{about['title']} (lerobot's “{about['type']}”, size {about['size']}), after {about['steps']} steps on generated trajectories of which there were "
            f"{about['train_count']}, drives ({_networks(about)}) in the {' and the '.join(about['worlds']) or 'closed loop: no trial was run'}; garments: {', '.join(about['garments']) or 'none'}.",
            "Success in percent with intervals and counts. Change: against the trials of the same network and number in-domain, which meet the same placement "
            "(spatial: the same direction, further away) and the same look but for what is changed; percentage points with Newcombe's 95 % interval for "
            "pairs. Average: here over all trials that were run; those from one placement hang together there.",
            *([said_of_intervals({about["title"]: every.network_count})] if every else []),
            paper.MEANT_WITH_PICTURES,
        ],
        table=[
            *(_row(found.get(shift), {"Shift": shift}) for shift in paper.SHIFTS),
            _row(every, {"Shift": paper.AVERAGE}),
        ],
        pictures=[Picture(path=picture)] if picture.exists() else [],
    )


def _networks(about: Mapping[str, Any]) -> str:
    count = len(about["network_seeds"])
    return "one network" if count == 1 else f"{count} networks"


def strip_section(artifact: Path, heading: str = "Film strips") -> Section:
    """What the policy saw."""
    pictures = [artifact / f"trials_{shift}.png" for shift in SHIFTS]
    shown = [Picture(path=path) for path in pictures if path.exists()]
    return Section(heading=heading, paragraphs=[STRIPS if shown else "None: no trial was run."], pictures=shown)


def _row(one: ShiftTried | None, names: dict[str, object]) -> dict[str, object]:
    shift = str(names["Shift"])
    failures = sorted(one.failures.items(), key=lambda item: (-item[1], item[0])) if one else ()
    return {
        **names,
        "Success (%) | here": rate(one.success_count, one.trial_count, one.interval) if one else NOT_RUN,
        "Success (%) | paper": paper.ABLATION[paper.FULL].get(shift),
        "Change (points)": None
        if shift in (IN_DOMAIN, paper.AVERAGE)
        else percentage_points(one.change if one else None),
        "Failures": ", ".join(together(f"{count} {name}") for name, count in failures),
    }


def _changes(about: Mapping[str, Any]) -> list[str]:
    factors = " and ".join(map(str, about["friction_factors"]))
    return [
        f"The garment is laid down within {1e3 * about['laid_m']:.0f} mm of where it was demonstrated; spatial: moved by up to {1e3 * about['shift_m']:.0f} mm "
        f"and turned by up to {np.degrees(about['turn_rad']):.0f} degrees. Placements are those that state policies of the same network seed meet in stage policy.",
        "A trial's look is that of a training clip, drawn by network and number, the same in all shifts. Lighting: lamps and sky of a light of another name. Viewpoint: the head "
        f"camera turned about the table's middle to {about['viewpoint_deg']:g}° of elevation beyond all that training has seen, down in even trials and up in odd ones. "
        f"Texture: another fabric and table, and friction of all contacts taken times {factors} in turn, as the paper's texture shift changes friction too. What is new comes "
        "from the distribution that training looks come from; noise of the pictures is the same in all shifts.",
    ]


def _method(about: Mapping[str, Any]) -> list[str]:
    times = ", ".join(
        f"{garment} {limit['duration_s']:.1f} s (by {NAMES[limit['longest_of']]})"
        for garment, limit in about["time_limits"].items()
    )
    driving, pictures = about["driving"], "; ".join(_rendered(*item) for item in about["pictures"].items())
    return [
        f"Trials for each garment, network and shift: {about['each']}; shifts: {', '.join(about['shifts'])}. Network seeds: {', '.join(map(str, about['network_seeds']))}, on {about['device']}. "
        f"The policy plans {driving['rate_hz'] / driving['replan_frames']:g} times a second: it is given the state and the pictures of that moment and predicts {about['chunk_frames']} commands "
        f"at {driving['rate_hz']} Hz; chunks that speak of the same frame are averaged, weights exp(−{driving['decay']:g} × age in chunks). A trial lasts {about['time_factor']:g} times the "
        f"longest trajectory of its garment: {times or 'none'}; it is judged at its end.",
        f"Pictures are rendered as the dataset's were: {pictures or 'none'}.",
    ]


def _rendered(garment: str, shown: Mapping[str, Any]) -> str:
    return (
        f"{garment} with {shown['engine']}, {shown['width']} × {shown['height']}, {shown['samples']} samples, seen by {', '.join(shown['cameras'])}; "
        f"looks of training: {shown['trained_looks']}"
    )
