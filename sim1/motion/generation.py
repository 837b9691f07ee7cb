"""The work of stage candidate_trajectories: attempts one after the other, each from its own random stream."""

from __future__ import annotations

import dataclasses
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import torch

from sim1.cloth.cell import Cell, CellConfig, SimulationBroke
from sim1.cloth.garment import GarmentMesh, read_garment_mesh
from sim1.cloth.physics import read_physics
from sim1.episode import Episode, read_episode, read_start, write_episode
from sim1.motion.assembly import Attempt, Source, attempt
from sim1.motion.commands import Arms
from sim1.motion.home import demo_folders, home_of
from sim1.motion.joining import Variation
from sim1.motion.model import MotionModel, read_model
from sim1.motion.pictures import draw_attempts
from sim1.motion.placement import unplaced
from sim1.motion.pool import Segment, read_pool
from sim1.progress import report
from sim1.robot.expert_task import Task, read_task
from sim1.scene.description import Scene, read_scene
from sim1.stage import BadInput, Facts, Inputs, only, random_stream
from sim1.validity.clips import head_clip, write_clip
from sim1.validity.success import judge

if TYPE_CHECKING:
    from sim1.motion.stage import CandidateTrajectoriesConfig


@dataclass(frozen=True, kw_only=True)
class _Judged:
    """An attempt with its verdict."""

    number: int
    perturbed: bool
    attempt: Attempt
    success: bool
    failure: str | None
    figures: dict[str, float]

    def row(self) -> dict[str, Any]:
        """Row of `attempts.parquet`."""
        ran = self.attempt.episode
        return {
            "attempt": self.number,
            "episode": f"{self.number:04d}",
            "perturbed": self.perturbed,
            "ran": ran is not None,
            "success": self.success,
            "failure": self.failure,
            "detail": self.attempt.detail,
            "frame_count": ran.frame_count if ran else 0,
            "speed_share": self.attempt.speed_share,
            "segments": [source["segment"] for source in self.attempt.sources],
            "demos": [source["demo"] for source in self.attempt.sources],
            "placement": self.attempt.placement.ravel().tolist(),
            **{f"figure.{name}": value for name, value in sorted(self.figures.items())},
        }

    def about(self) -> dict[str, Any]:
        """What the episode says of itself."""
        return {
            "kind": "candidate",
            "attempt": self.number,
            "perturbed": self.perturbed,
            "sources": sorted({source["demo"] for source in self.attempt.sources}),
            "segments": self.attempt.sources,
            "placement": self.attempt.placement.tolist(),
            "success": self.success,
            "failure": self.failure,
            "figures": {name: float(value) for name, value in sorted(self.figures.items())},
        }


def generate(inputs: Inputs, garment: str, config: CandidateTrajectoriesConfig, out: Path) -> Facts:
    """Make, run, judge and write all attempts of one garment."""
    torch.set_num_threads(1)
    mesh = read_garment_mesh(only(inputs, "garment_mesh"))
    scene = read_scene(only(inputs, "scene"))
    demos = only(inputs, "seed_demos")
    task = read_task(demos / "task.json")
    pool, model = read_pool(only(inputs, "segment_pool")), read_model(only(inputs, "motion_model"))
    source, arms = read_source(demos), Arms.of_scene(scene)
    physics = read_physics(only(inputs, "calibrated_physics") / "cell.yaml")
    cell = Cell(mesh, scene, physics, source.cell)
    bench = _Bench(garment=garment, mesh=mesh, scene=scene, task=task, pool=pool, model=model, source=source, arms=arms,
                   cell=cell, config=config, out=out)  # fmt: skip
    rows: list[dict[str, Any]] = []
    ends: list[np.ndarray | None] = []
    total = config.candidate_count + config.perturbed_count
    for perturbed in (False, True):
        group: list[dict[str, Any]] = []
        while wants_more(group, perturbed, config):
            report(min(sum(row["ran"] for row in rows), total - 1), total, "candidates")
            row, end = bench.run(len(rows), perturbed)
            rows.append(row)
            group.append(row)
            ends.append(end)
    report(total, total, "candidates")
    pd.DataFrame(rows).to_parquet(out / "attempts.parquet", index=False)
    draw_attempts(out / "attempts.png", rows, ends, source.home.start_m)
    return _facts(rows)


def wants_more(group: list[dict[str, Any]], perturbed: bool, config: CandidateTrajectoriesConfig) -> bool:
    """Whether another attempt is to be made, after those in `group`."""
    ran, succeeded = sum(row["ran"] for row in group), sum(row["success"] for row in group)
    if perturbed:
        return ran < config.perturbed_count and len(group) < config.tries_per_candidate * config.perturbed_count
    if len(group) >= config.tries_per_candidate * config.candidate_count:
        return False
    return ran < config.candidate_count or (succeeded < config.success_target and ran < config.run_limit)


@dataclass(frozen=True, kw_only=True)
class _Bench:
    """Everything that all attempts of a garment share."""

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
    out: Path

    def run(self, number: int, perturbed: bool) -> tuple[dict[str, Any], np.ndarray | None]:
        """Make, judge and write one attempt: its row, and where the garment ended."""
        config = self.config
        variation = Variation(
            radius_m=config.radius_m,
            angle_rad=float(np.radians(config.angle_deg)),
            grasp_offset_m=config.perturbation_m if perturbed else 0.0,
            settle_s=config.settle_s,
        )
        stream = random_stream(config.seed, self.garment, "candidate", number)
        made = attempt(self.pool, self.source, self.model, self.arms, self.cell, variation, stream, SimulationBroke)
        verdict = _judged(number, perturbed, made, self.source.home.start_m, self.mesh.faces, self.task)
        if made.episode is None:
            return verdict.row(), None
        folder = self.out / "episodes" / f"{number:04d}"
        about = {
            "garment": self.garment,
            "seed": config.seed,
            "method": self.model.method,
            "cell": asdict(self.source.cell),
        }
        write_episode(folder, dataclasses.replace(made.episode, about=about | verdict.about()))
        size = {"rate_hz": config.video_rate_hz, "width": config.video_width, "height": config.video_height}
        write_clip(folder, head_clip(made.episode.garment_m, self.mesh.faces, self.scene, **size))
        return verdict.row(), made.episode.garment_m[-1]


def read_source(demos: Path) -> Source:
    """What `attempt` needs of the demonstrations.

    Raises:
        BadInput: a file is missing or damaged.
    """
    episodes = {folder.name: read_episode(folder) for folder in demo_folders(demos)}
    first = next(iter(episodes.values()))
    return Source(
        home=home_of(read_start(demos), first),
        garment_m={name: episode.garment_m for name, episode in episodes.items()},
        cell=_cell_config(demos, first),
    )


def _cell_config(demos: Path, demo: Episode) -> CellConfig:
    """Numerics of the demonstrations: candidates run in the same simulation."""
    try:
        return CellConfig(**demo.about["cell"])
    except (KeyError, TypeError, ValueError) as error:
        raise BadInput(
            f"{demos}/episodes: no usable cell settings in episode.json ({error}); make seed_demos again"
        ) from error


def _judged(number: int, perturbed: bool, made: Attempt, start_m: np.ndarray, faces: np.ndarray, task: Any) -> _Judged:
    success, failure, figures = False, made.failure, {}
    if made.failure is None and made.episode is not None:
        judgement = judge(unplaced(made.episode.garment_m, start_m), faces, task)
        success, failure, figures = judgement.success, judgement.failure, dict(judgement.figures)
    return _Judged(
        number=number, perturbed=perturbed, attempt=made, success=bool(success), failure=failure, figures=figures
    )


def _facts(rows: list[dict[str, Any]]) -> Facts:
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
        "negative_examples": sum(not row["success"] for row in rows if row["ran"])
        or "none: the filters see no failure",
        "failures": [{"class": name, "count": count} for name, count in sorted(failures.items())],
    }
