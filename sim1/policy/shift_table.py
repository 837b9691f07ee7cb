"""How often the garment was folded, by shift and by garment, in the form of the paper's tables and with its figures beside ours."""

from collections.abc import Sequence

from sim1.policy import paper
from sim1.policy.counting import NOT_RUN, rate, together
from sim1.policy.lessons import GENERATED, KINDS, NAMES, REAL, SIMULATED
from sim1.policy.scaling import Point, Task, Tried
from sim1.report import Section
from sim1.statistics import difference_interval

OURS = {
    "in-domain": "in-domain",
    "spatial": "spatial",
    "texture": "friction",
}  # of the paper's shifts those that are tried here
PAPER = {GENERATED: paper.ABLATION[paper.FULL], SIMULATED: paper.TELEOPERATED, REAL: paper.REAL}


def shift_section(points: Sequence[Point]) -> Section:
    """Success by shift after each source of training, at the largest number of trajectories that drove."""
    largest = {kind: _largest(points, kind) for kind in KINDS}
    return Section(
        heading="Success by shift",
        paragraphs=[
            "Success in percent at the largest number of trajectories that drove, with 95 % Wilson intervals and counts. "
            "Texture: here friction alone, as the policy that drives sees no pictures; for the same reason lighting and viewpoint are not run (those of the "
            "policy that sees pictures: section “Image policy in the closed loop”, stage image_trials). "
            "Average: here over all trials that were run. Generated minus real: percentage points with Newcombe's 95 % interval. All these intervals take "
            "trials as independent, those of one network too, and are too narrow where networks differ; all networks of a size learnt from the same "
            "trajectories, and what others would teach is in no interval.",
            f"{paper.MEANT} Its generated trajectories: the last line of its ablation table. Its demonstrations, in the simulator by "
            "teleoperation and real ones by hand, 200 each: the text gives averages, and does not say over which shifts.",
        ],
        table=[_row(shift, largest) for shift in (*paper.SHIFTS, paper.AVERAGE)],
    )


def task_section(tasks: Sequence[Task]) -> Section:
    """Success by garment after generated trajectories."""
    here = {task.garment: task for task in tasks}
    printed = {"tshirt": paper.ABLATION[paper.FULL]["in-domain"], **paper.TASKS}
    return Section(
        heading="Success by garment",
        paragraphs=[
            "In-domain, after the largest number of generated trajectories; 95 % Wilson intervals and counts. Paper: 30 trials a garment "
            "on a real robot; the polo shirt there without any demonstration of it, here with demonstrations."
        ],
        table=[
            {
                "Garment": garment,
                "Generated trajectories": here[garment].size if garment in here else None,
                "Success (%) | here": _rate(here[garment].tried if garment in here else None),
                "Success (%) | paper": printed.get(garment),
            }
            for garment in dict.fromkeys([*printed, *here])
        ],
    )


def _largest(points: Sequence[Point], kind: str) -> Point | None:
    drove = [point for point in points if point.trained_on == kind and point.trials]
    return max(drove, key=lambda point: point.size, default=None)


def _row(shift: str, largest: dict[str, Point | None]) -> dict[str, object]:
    row: dict[str, object] = {"Shift": shift}
    tried = {kind: _tried(point, shift) for kind, point in largest.items()}
    for kind, point in largest.items():
        heading = f"{NAMES[kind].capitalize()}{f', {point.size}' if point else ''}"
        row[f"{heading} | here"] = _rate(tried[kind])
        row[f"{heading} | paper"] = PAPER[kind].get(shift)
    row["Generated minus real | here"] = _difference(tried[GENERATED], tried[REAL])
    over = paper.GENERATED_OVER_REAL.get(shift)
    row["Generated minus real | paper"] = None if over is None else f"{over:+d}"
    return row


def _tried(point: Point | None, shift: str) -> tuple[int, int]:
    """Successes and trials; none where it was not run."""
    shown: Sequence[Tried] = point.trials if point else ()
    if shift != paper.AVERAGE:
        shown = [one for one in shown if one.shift == OURS.get(shift)]
    return sum(one.success_count for one in shown), sum(one.trial_count for one in shown)


def _difference(one: tuple[int, int], other: tuple[int, int]) -> str:
    if not (one[1] and other[1]):
        return NOT_RUN
    low, high = difference_interval(one, other)
    return together(f"{100 * (one[0] / one[1] - other[0] / other[1]):+.0f} ({100 * low:+.0f} to {100 * high:+.0f})")


def _rate(tried: tuple[int, int] | Tried | None) -> str:
    if isinstance(tried, Tried):
        tried = tried.success_count, tried.trial_count
    return rate(*(tried or (0, 0)))
