"""One attempt of Algorithm 1: drawn from its own random stream, run in the cell, judged, written."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from sim1.cloth.cell import Cell, CellConfig, SimulationBroke
from sim1.cloth.garment import GarmentMesh, read_garment_mesh
from sim1.cloth.physics import physics_record, read_physics
from sim1.episode import Episode, read_episode, read_start, write_episode
from sim1.motion.assembly import Attempt, Source, attempt
from sim1.motion.commands import Arms
from sim1.motion.home import demo_folders, home_of
from sim1.motion.joining import Variation
from sim1.motion.model import MotionModel, read_model
from sim1.motion.placement import unplaced
from sim1.motion.pool import Segment, by_demo, read_pool
from sim1.quota import Row, Ticket
from sim1.robot.expert_task import Task, read_task
from sim1.scene.description import Scene, read_scene
from sim1.stage import BadInput, Inputs, only, random_stream
from sim1.validity.clips import head_clip, write_clip
from sim1.validity.raster import in_view_share
from sim1.validity.success import CUT_SHORT, OUT_OF_VIEW, judge

if TYPE_CHECKING:
    from sim1.motion.stage import CandidateTrajectoriesConfig

IN_VIEW_LEAST = 0.98  # of the garment, all the time: what the head camera does not see, a policy cannot learn from


@dataclass(frozen=True, kw_only=True)
class Bench:
    """Everything that all attempts of a garment share; a maker of attempts (`sim1.crew.Maker`)."""

    garment: str
    mesh: GarmentMesh
    scene: Scene
    task: Task
    pool: list[Segment]
    model: MotionModel
    source: Source
    arms: Arms
    cell: Cell
    config: CandidateTrajectoriesConfig

    @classmethod
    def of(cls, inputs: Inputs, garment: str, config: CandidateTrajectoriesConfig) -> Bench:
        """Read what the stage candidate_trajectories is given.

        Raises:
            BadInput: a file is missing or damaged.
        """
        torch.set_num_threads(1)
        mesh, scene = read_garment_mesh(only(inputs, "garment_mesh")), read_scene(only(inputs, "scene"))
        demos = only(inputs, "seed_demos")
        pool = read_pool(only(inputs, "segment_pool"))
        source = read_source(demos, pool)
        numerics = replace(source.cell, solver=config.solver)
        physics = read_physics(only(inputs, "calibrated_physics") / "cell.yaml")
        return cls(
            garment=garment,
            mesh=mesh,
            scene=scene,
            task=read_task(demos / "task.json"),
            pool=pool,
            model=read_model(only(inputs, "motion_model")),
            source=source,
            arms=Arms.of_scene(scene),
            cell=Cell(mesh, scene, physics, numerics),
            config=config,
        )

    def run(self, ticket: Ticket) -> Attempt:
        """Draw, plan and run one attempt; the same bytes every time."""
        variation = Variation(
            radius_m=self.config.radius_m,
            angle_rad=float(np.radians(self.config.angle_deg)),
            grasp_offset_m=self.config.perturbation_m if ticket.series == "perturbed" else 0.0,
            settle_s=self.config.settle_s,
        )
        stream = random_stream(self.config.seed, self.garment, "candidate", ticket.series or "meant", ticket.number)
        return attempt(self.pool, self.source, self.model, self.arms, self.cell, variation, stream, SimulationBroke)

    def make(self, ticket: Ticket, folder: Path) -> Row:
        """Run and judge one attempt: its row, and episode and video in `folder` where it ran."""
        made = self.run(ticket)
        success, failure, figures = self._judged(made)
        about = {
            "kind": "candidate",
            "garment": self.garment,
            "task_text": self.task.instruction(self.garment),
            "seed": self.config.seed,
            "attempt": ticket.number,
            "perturbed": ticket.series == "perturbed",
            "method": self.model.method,
            "cell": asdict(self.cell.config),
            "physics": physics_record(self.cell.physics),
            "sources": sorted({source["demo"] for source in made.sources}),
            "segments": made.sources,
            "placement": made.placement.tolist(),
            "success": success,
            "failure": failure,
            "figures": figures,
        }
        if made.episode is not None:
            write_episode(folder, replace(made.episode, about=about))
            config = self.config
            size = {"rate_hz": config.video_rate_hz, "width": config.video_width, "height": config.video_height}
            write_clip(folder, head_clip(made.episode.garment_m, self.mesh.faces, self.scene, **size))
        return {
            "attempt": ticket.number,
            "episode": ticket.name,
            "perturbed": ticket.series == "perturbed",
            "ran": made.episode is not None,
            "success": success,
            "failure": failure,
            "detail": made.detail,
            "frame_count": made.episode.frame_count if made.episode else 0,
            "speed_share": made.speed_share,
            "segments": [source["segment"] for source in made.sources],
            "demos": [source["demo"] for source in made.sources],
            "placement": made.placement.ravel().tolist(),
            **{f"figure.{name}": value for name, value in figures.items()},
        }

    def _judged(self, made: Attempt) -> tuple[bool, str | None, dict[str, float | None]]:
        if made.failure is not None or made.episode is None:
            return False, made.failure, {}
        judgement = judge(unplaced(made.episode.garment_m, self.source.home.start_m), self.mesh.faces, self.task)
        seen = in_view_share(made.episode.garment_m, self.scene)
        failure = judgement.failure or (OUT_OF_VIEW if seen < IN_VIEW_LEAST else None)
        figures = {name: float(value) for name, value in sorted({**judgement.figures, "in_view_share": seen}.items())}
        finite = {name: value if math.isfinite(value) else None for name, value in figures.items()}
        return failure is None, failure, finite


def read_source(demos: Path, pool: list[Segment]) -> Source:
    """What `attempt` needs of the demonstrations: of their garments the states in which an interaction of `pool` starts.

    Raises:
        BadInput: a file is missing or damaged.
    """
    first = read_episode(demo_folders(demos)[0])
    garment_m: dict[tuple[str, int], np.ndarray] = {}
    for demo, parts in by_demo(pool).items():
        frames = [part.start_frame for part in parts if part.kind == "interacting" and part.success]
        if frames:
            whole_m = read_episode(demos / "episodes" / demo).garment_m
            garment_m |= {(demo, frame): whole_m[frame].copy() for frame in frames}  # a view would keep the whole
    return Source(home=home_of(read_start(demos), first), garment_m=garment_m, cell=_cell_config(demos, first))


def _cell_config(demos: Path, demo: Episode) -> CellConfig:
    """Numerics of the demonstrations: candidates run in the same simulation."""
    try:
        return CellConfig(**demo.about["cell"])
    except (KeyError, TypeError, ValueError) as error:
        raise BadInput(
            f"{demos}/episodes: no usable cell settings in episode.json ({error}); make seed_demos again"
        ) from error


def facts(rows: list[Row]) -> dict[str, Any]:
    """Counts that people read first."""
    meant = [row for row in rows if not row["perturbed"]]
    failures: dict[str, int] = {}
    for row in rows:
        if row["failure"]:
            failures[row["failure"]] = failures.get(row["failure"], 0) + 1
    return {
        "attempt_count": len(rows),
        "success_count": sum(row["success"] for row in meant),
        "of_unperturbed": len(meant),
        "perturbed_count": len(rows) - len(meant),
        "perturbed_success_count": sum(row["success"] for row in rows if row["perturbed"]),
        "negative_examples": sum(not row["success"] for row in rows if row["ran"] and row["failure"] not in CUT_SHORT)
        or "none: the filters see no failure",
        "failures": [{"class": name, "count": count} for name, count in sorted(failures.items())],
    }
