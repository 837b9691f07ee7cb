"""Running the cell: settle the garment, demonstrate a task, replay a recorded command stream."""

from contextlib import suppress
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from sim1.cloth.cell import Cell, SimulationBroke
from sim1.cloth.physics import physics_record
from sim1.episode import RATE_HZ, Episode
from sim1.robot.expert import TooFast, Workspace, plan_step
from sim1.robot.expert_task import Task
from sim1.robot.expert_variation import Variation
from sim1.robot.kinematics import Unreachable
from sim1.robot.teleoperation import Commands, at_limits, not_followed
from sim1.stage import BadInput
from sim1.validity.success import judge

END_HOLD_S = 1.2  # the garment comes to rest before it is judged


class Recorder:
    """Collects what happens in a cell, one frame per command."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._rows: dict[str, list[np.ndarray]] = {
            name: [] for name in ("joints_rad", "openness", "command_joints_rad", "command_openness", "garment_m")
        }

    def step(self, joints_rad: np.ndarray, openness: np.ndarray) -> None:
        """Note the state and the command, then let the cell follow it."""
        cell = self._cell
        now = (cell.joints_rad, cell.openness, joints_rad, openness, cell.garment_m)
        for row, value in zip(self._rows.values(), now, strict=True):
            row.append(np.array(value))
        cell.step(joints_rad, openness)

    def episode(self, about: dict[str, Any]) -> Episode:
        """What was recorded so far."""
        arrays = {name: np.array(rows) for name, rows in self._rows.items()}
        count = len(arrays["openness"])
        return Episode(time_s=np.arange(count) / RATE_HZ, **arrays, about=about)


def settle(cell: Cell, *, longest_s: float, rest_speed_m_s: float) -> np.ndarray:
    """Let the garment fall from its lying pose onto the table, arms at home, until it rests: (v, 3) float32.

    Raises:
        BadInput: it has not come to rest, or lies beside the table.
    """
    home = Workspace.of(cell.arms, cell.scene).home_rad
    cell.reset(cell.scene.place_garment(cell.garment.vertices_m), home, np.ones(2))
    speed_m_s = np.inf
    for _ in range(round(longest_s * RATE_HZ)):
        cell.step(home, np.ones(2))
        speed_m_s = np.linalg.norm(cell.garment_m_s, axis=1).max()
        if cell.frame > 10 and speed_m_s < rest_speed_m_s:
            break
    garment = cell.garment_m
    if garment[:, 2].min() < -0.02:
        raise BadInput(
            f"the garment slid off the table ({garment[:, 2].min():.3f} m); check garment.place of the scene"
        )
    if not speed_m_s < rest_speed_m_s:
        raise BadInput(
            f"{longest_s} s after the garment was laid down a vertex still moves at {speed_m_s:.3f} m/s, at rest is "
            f"below {rest_speed_m_s}; give it longer (settle_s), or check its mesh and fabric"
        )
    return garment


def demonstrate(cell: Cell, task: Task, start_m: np.ndarray, variation: Variation, about: dict[str, Any]) -> Episode:
    """Do the task on the garment that lies at `start_m` (v, 3); the episode says how it went, also when it failed."""
    workspace = Workspace.of(cell.arms, cell.scene)
    cell.reset(start_m, workspace.home_rad, np.ones(2))
    recorder = Recorder(cell)
    failure, note, last = None, "", (workspace.home_rad, np.ones(2))
    try:
        for index in range(len(task.steps)):
            plan = plan_step(workspace, task, index, start_m, cell.garment_m, cell.joints_rad, variation)
            for last in zip(plan.joints_rad, plan.openness):
                recorder.step(*last)
    except Unreachable as error:
        failure, note = "unreachable", str(error)
    except TooFast as error:
        failure, note = "too fast", str(error)
    except SimulationBroke as error:
        failure, note = "simulation broke", str(error)
    return _judged(recorder, cell, task, about, last, failure, note)


def follow(cell: Cell, task: Task, start_m: np.ndarray, commands: Commands, about: dict[str, Any]) -> Episode:
    """Let the arms do what a person asked of them, with the garment at `start_m` (v, 3); the episode says how it went.

    What passes a joint's limit by rounding alone is recorded at that limit. Commands that the arms cannot follow are a
    failure, whatever became of the garment.
    """
    cell.reset(start_m, commands.start_joints_rad, commands.start_openness)
    recorder = Recorder(cell)
    asked_rad, reached_rad = at_limits(commands.joints_rad, cell.arms), []
    failure, note, last = None, "", (asked_rad[-1], commands.openness[-1])
    try:
        for asked in zip(asked_rad, commands.openness):
            recorder.step(*asked)
            reached_rad.append(np.array(cell.joints_rad))
        failure, note = not_followed(commands.origin, asked_rad, np.array(reached_rad), cell.arms) or (None, "")
    except SimulationBroke as error:
        failure, note = "simulation broke", str(error)
    return _judged(recorder, cell, task, about, last, failure, note)


def _judged(
    recorder: Recorder,
    cell: Cell,
    task: Task,
    about: dict[str, Any],
    last: tuple[np.ndarray, np.ndarray],
    failure: str | None,
    note: str,
) -> Episode:
    """The episode once the garment has come to rest under arms that stay at their `last` command, and what the judge says."""
    if failure != "simulation broke":
        try:
            for _ in range(round(END_HOLD_S * RATE_HZ)):
                recorder.step(*last)
        except SimulationBroke as error:  # what it fails by already is what it is known by
            failure, note = (failure, note) if failure else ("simulation broke", str(error))
    episode = recorder.episode(about)
    outcome = judge(episode.garment_m, cell.garment.faces, task)
    failure = failure or outcome.failure
    told = {"success": failure is None, "failure": failure, "figures": outcome.figures, "note": note}
    return replace(
        episode, about={**about, **told, "cell": asdict(cell.config), "physics": physics_record(cell.physics)}
    )


def replay(cell: Cell, episode: Episode) -> Episode:
    """Drive the cell with a recorded command stream from the recorded first state; on CPU it gives the same bytes.

    Where the simulation breaks, the replay ends with the frames until then, as an episode that breaks is recorded.
    """
    cell.reset(episode.garment_m[0], episode.joints_rad[0], episode.openness[0])
    recorder = Recorder(cell)
    with suppress(SimulationBroke):
        for joints, openness in zip(episode.command_joints_rad, episode.command_openness):
            recorder.step(joints, openness)
    return recorder.episode(episode.about)


def shortened(episode: Episode, seconds: float) -> Episode:
    """The first `seconds` of an episode."""
    count = max(2, round(seconds * RATE_HZ))
    names = ("time_s", "joints_rad", "openness", "command_joints_rad", "command_openness", "garment_m")
    return replace(episode, **{name: getattr(episode, name)[:count] for name in names})
