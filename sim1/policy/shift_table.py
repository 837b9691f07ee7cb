"""How often the garment was folded, by shift and by garment, in the form of the paper's tables and with its figures beside ours."""

from collections.abc import Mapping, Sequence

from sim1.clustered_share import Difference
from sim1.policy import paper
from sim1.policy.counting import NOT_RUN, percentage_points, rate
from sim1.policy.lessons import GENERATED, KINDS, NAMES, REAL, SIMULATED
from sim1.policy.scaling import Point, Task
from sim1.policy.tried import Tried, said_of_intervals
from sim1.report import Section

OURS = {
    "in-domain": "in-domain",
    "spatial": "spatial",
    "texture": "friction",
}  # of the paper's shifts those that are tried here
PAPER = {GENERATED: paper.ABLATION[paper.FULL], SIMULATED: paper.TELEOPERATED, REAL: paper.REAL}


def shift_section(points: Sequence[Point], over_real: Mapping[str, Difference]) -> Section:
    """Success by shift after each source of training, at the largest number of trajectories that drove."""
    largest = {kind: _largest(points, kind) for kind in KINDS}
    networks = {NAMES[kind]: point.all_trials.network_count for kind, point in largest.items() if point}
    return Section(
        heading="Success by shift",
        paragraphs=[
            "Success in percent at the largest number of trajectories that drove, with intervals and counts. "
            "Texture: here friction alone, as the policy that drives sees no pictures; for the same reason lighting and viewpoint are not run (those of the "
            "policy that sees pictures: section “Image policy in the closed loop”, stage image_trials). "
            "Average: here over all trials that were run. Generated minus real: percentage points over trials from the same placements, with Newcombe's 95 % interval for pairs from the "
            "intervals of either side.",
            *([said_of_intervals(networks)] if networks else []),
            f"{paper.MEANT} Its generated trajectories: the last line of its ablation table. Its demonstrations, in the simulator by "
            "teleoperation and real ones by hand, 200 each: the text gives averages, and does not say over which shifts.",
        ],
        table=[_row(shift, largest, over_real) for shift in (*paper.SHIFTS, paper.AVERAGE)],
    )


def task_section(tasks: Sequence[Task]) -> Section:
    """Success by garment after generated trajectories."""
    here = {task.garment: task for task in tasks}
    printed = {"tshirt": paper.ABLATION[paper.FULL]["in-domain"], **paper.TASKS}
    return Section(
        heading="Success by garment",
        paragraphs=[
            "In-domain, after the largest number of generated trajectories; intervals, of all networks together, and counts. Paper: 30 trials a garment "
            "on a real robot; the polo shirt there without any demonstration of it, here with demonstrations.",
            *([said_of_intervals({task.garment: task.tried.network_count for task in tasks})] if tasks else []),
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


def _row(shift: str, largest: Mapping[str, Point | None], over_real: Mapping[str, Difference]) -> dict[str, object]:
    row: dict[str, object] = {"Shift": shift}
    for kind, point in largest.items():
        heading = f"{NAMES[kind].capitalize()}{f', {point.size}' if point else ''}"
        row[f"{heading} | here"] = _rate(_tried(point, shift))
        row[f"{heading} | paper"] = PAPER[kind].get(shift)
    row["Generated minus real | here"] = percentage_points(over_real.get(OURS.get(shift, shift)))
    over = paper.GENERATED_OVER_REAL.get(shift)
    row["Generated minus real | paper"] = None if over is None else f"{over:+d}"
    return row


def _tried(point: Point | None, shift: str) -> Tried | None:
    """None where it was not run."""
    if point is None or shift == paper.AVERAGE:
        return point and point.all_trials
    return next((one for one in point.trials if one.shift == OURS.get(shift)), None)


def _rate(tried: Tried | None) -> str:
    return rate(tried.success_count, tried.trial_count, tried.interval) if tried else NOT_RUN
