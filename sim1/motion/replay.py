"""Episodes simulated again from what is recorded of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim1.cloth.cell import Cell, CellConfig
from sim1.cloth.garment import read_garment_mesh
from sim1.cloth.physics import physics_of_record
from sim1.episode import Episode, read_episode
from sim1.motion.bench import Bench
from sim1.quota import Ticket
from sim1.robot.session import replay
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Inputs, only

if TYPE_CHECKING:
    from sim1.motion.stage import CandidateTrajectoriesConfig

ARRAYS = ("time_s", "joints_rad", "openness", "command_joints_rad", "command_openness", "garment_m")


@dataclass(frozen=True, kw_only=True)
class Compared:
    """An episode beside its replay."""

    name: str
    frame_count: int
    replayed_count: int
    differing: str | None  # the array that differs first
    frame: int | None  # where
    largest: float  # difference of any number of it, in its unit

    @property
    def same(self) -> bool:
        """Whether every byte is."""
        return self.differing is None and self.frame_count == self.replayed_count

    def said(self) -> str:
        """One line for a person."""
        if self.same:
            return f"{self.name}: {self.frame_count} frames again, the same bytes"
        if self.differing is None:
            return f"{self.name}: {self.replayed_count} frames in place of {self.frame_count}"
        return (
            f"{self.name}: differs from frame {self.frame} of {self.frame_count} on, first in {self.differing}, "
            f"by at most {self.largest:.3g}"
        )


def replay_commands(inputs: Inputs, folder: Path) -> Compared:
    """Drive the cell with the recorded commands from the recorded first state.

    The physics is the recorded one: whatever was calibrated since, an episode is replayed in the fabric that it was made in.

    Args:
        inputs: the garment's mesh and scene.
        folder: of the episode.

    Raises:
        BadInput: a file is missing or damaged.
    """
    recorded = read_episode(folder)
    for key in ("cell", "physics"):
        if key not in recorded.about:
            raise BadInput(
                f"{folder}/episode.json: key {key} is missing; only an episode of the simulated cell is replayed, "
                "and one from before its record had the physics must be made again"
            )
    mesh, scene = read_garment_mesh(only(inputs, "garment_mesh")), read_scene(only(inputs, "scene"))
    physics = physics_of_record(recorded.about["physics"], f"{folder}/episode.json: physics")
    again = replay(Cell(mesh, scene, physics, CellConfig(**recorded.about["cell"])), recorded)
    return compared(folder.name, recorded, again)


def replay_seed(inputs: Inputs, garment: str, config: CandidateTrajectoriesConfig, folder: Path) -> Compared:
    """Draw, plan and run a generated episode again from its seed, series and number.

    Raises:
        BadInput: a file is missing or damaged, or the episode was not generated.
    """
    recorded = read_episode(folder)
    about = recorded.about
    if about.get("kind") != "candidate":
        raise BadInput(
            f"{folder}/episode.json: kind is {about.get('kind')!r}; only generated episodes have a seed to draw"
        )
    ticket = Ticket(series="perturbed" if about["perturbed"] else "", number=about["attempt"])
    again = Bench.of(inputs, garment, replace(config, seed=about["seed"])).run(ticket).episode
    if again is None:
        raise BadInput(f"{folder}: attempt {ticket.name} does not run with these inputs, so they did not make it")
    return compared(folder.name, recorded, again)


def compared(name: str, recorded: Episode, again: Episode) -> Compared:
    """Where two episodes differ first, bit for bit."""
    count = min(recorded.frame_count, again.frame_count)
    differing, frame, largest = None, None, 0.0
    for array in ARRAYS:
        one, two = getattr(recorded, array)[:count], getattr(again, array)[:count]
        rows = np.flatnonzero((one != two).reshape(count, -1).any(axis=1))
        if len(rows) and (frame is None or rows[0] < frame):
            differing, frame, largest = array, int(rows[0]), float(np.abs(one - two).max())
    return Compared(
        name=name, frame_count=recorded.frame_count, replayed_count=again.frame_count, differing=differing,
        frame=frame, largest=largest,
    )  # fmt: skip
