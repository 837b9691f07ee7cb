"""Closed-loop trials: the garment is moved at random, the policy drives, the judge decides."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sim1.cloth.cell import Cell, CellConfig, SimulationBroke
from sim1.cloth.garment import read_garment_mesh
from sim1.cloth.physics import read_physics
from sim1.episode import RATE_HZ, episode_folders, read_episode, read_start
from sim1.motion.placement import random_placement
from sim1.policy.model import ChunkPolicy
from sim1.policy.rollout import Driving, Start, roll_out
from sim1.policy.stage import PolicyConfig
from sim1.recording.reality import read_world
from sim1.robot.expert_task import read_task
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Inputs, random_stream
from sim1.validity.raster import render_head_view
from sim1.validity.success import judge

TRIAL_COLUMNS = (
    "world", "size", "seed", "garment", "trial", "success", "failure", "figures", "shift_x_m", "shift_y_m", "turn_rad", "simulated_s",
)  # fmt: skip
BROKEN = "simulation broke"  # the judge's word for it
REALITY, SIMULATOR = "stand-in reality", "simulator"
FINER = 2  # times the simulator's substeps: reality is not resolved by the same steps

type Judge = Callable[[np.ndarray], tuple[bool, str | None, Mapping[str, float]]]
"""Garment over time (T, v, 3) -> success, failure class, figures."""


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A garment's cell, ready for trials."""

    world: str  # REALITY or SIMULATOR
    cell: Any  # sim1.cloth.cell.Cell, or what behaves like it
    start: Start
    judge: Judge
    look: Callable[[np.ndarray], np.ndarray]  # garment (v, 3) -> picture (h, w, 3) u8


@dataclass(frozen=True, kw_only=True)
class FilmStrip:
    """One trial as a row of pictures."""

    title: str
    times_s: tuple[float, ...]
    pictures: tuple[np.ndarray, ...]


@dataclass(frozen=True, kw_only=True)
class TrialResults:
    """What came of all trials."""

    rows: list[dict[str, Any]]
    strips: list[FilmStrip]  # the first trial of every garment and model


@dataclass(frozen=True, kw_only=True)
class Trials:
    """What all trials share."""

    inputs: Inputs
    driving: Driving
    duration_s: float
    config: PolicyConfig

    def run(
        self,
        models: Mapping[tuple[int, int], ChunkPolicy],
        garments: Sequence[str],
        keypoints: Mapping[str, np.ndarray],
        progress: Callable[[float, str], None],
    ) -> TrialResults:
        """One row per garment, model and trial; every model meets the same placements."""
        rows: list[dict[str, Any]] = []
        strips: list[FilmStrip] = []
        total = len(models) * len(garments) * self.config.trial_count
        for garment in garments if total else ():
            bench = open_bench(self.inputs, garment, self.config.trials_in)
            for (size, seed), model in models.items():
                for trial in range(self.config.trial_count):
                    what = f"{garment}, policy of {size} trajectories, trial {trial + 1} of {self.config.trial_count}"

                    def on_frame(share: float, done: int = len(rows), what: str = what) -> None:
                        progress((done + share) / total, what)

                    outcome, history = self._trial(bench, model, garment, keypoints[garment], trial, on_frame)
                    rows.append(
                        {
                            "world": bench.world,
                            "size": size,
                            "seed": seed,
                            "garment": garment,
                            "trial": trial,
                            **outcome,
                        }
                    )
                    if trial == 0:
                        told = "success" if outcome["success"] else outcome["failure"]
                        strips.append(film_strip(f"{garment}, {size} trajectories: {told}", history, bench.look))
        progress(1.0, "trials done")
        return TrialResults(rows=rows, strips=strips)

    def _trial(
        self,
        bench: Bench,
        model: ChunkPolicy,
        garment: str,
        keypoints: np.ndarray,
        trial: int,
        on_frame: Callable[[float], None],
    ) -> tuple[dict[str, Any], np.ndarray]:
        rng = random_stream(self.config.seed, "trial", garment, trial)
        centre = bench.start.garment_m.mean(axis=0)
        placement = random_placement(rng, self.config.shift_m, self.config.turn_rad, centre)
        moved = bench.start.garment_m @ placement[:3, :3].T + placement[:3, 3]
        start = Start(garment_m=moved, joints_rad=bench.start.joints_rad, openness=bench.start.openness)
        shift = moved.mean(axis=0) - centre
        duration_s, history = self.duration_s, moved[None]
        try:
            history = roll_out(bench.cell, start, model, garment, keypoints, self.driving, duration_s, on_frame)
            # The task's fold lines lie along the world's axes: judged as if the garment had not been moved, a turned
            # garment that is folded along its own axes counts as folded.
            unmoved = (history - placement[:3, 3]) @ placement[:3, :3]
            success, failure, figures = bench.judge(unmoved)
        except SimulationBroke:
            success, failure, figures, duration_s = False, BROKEN, {}, bench.cell.frame / RATE_HZ
        outcome = {
            "success": success,
            "failure": failure,
            "figures": json.dumps({key: float(value) for key, value in sorted(figures.items())}),
            "shift_x_m": float(shift[0]),
            "shift_y_m": float(shift[1]),
            "turn_rad": float(np.arctan2(placement[1, 0], placement[0, 0])),
            "simulated_s": duration_s,
        }
        return outcome, history


def film_strip(title: str, history: np.ndarray, look: Callable[[np.ndarray], np.ndarray], count: int = 5) -> FilmStrip:
    """Evenly spaced pictures of a garment's run (T, v, 3), first and last frame included."""
    frames = sorted({round(place) for place in np.linspace(0, len(history) - 1, count)})
    return FilmStrip(
        title=title,
        times_s=tuple(frame / RATE_HZ for frame in frames),
        pictures=tuple(look(history[frame]) for frame in frames),
    )


def open_bench(inputs: Inputs, garment: str, trials_in: str) -> Bench:
    """A cell with a garment as the expert found it, and the judge of its task.

    In `reality` the fabric, air and friction are those of the stand-in, which no stage that made training data has seen, at finer
    steps. Where reality is real cloth, and in `simulator`, it is the cell that the training data come from.

    Raises:
        BadInput: an artifact of that garment is missing or damaged.
    """
    for name in ("garment_mesh", "scene", "calibrated_physics", "seed_demos", "reality"):
        if garment not in inputs.get(name, {}):
            raise BadInput(f"stage input {name!r}: none for garment {garment!r}; materialize it first")
    mesh = read_garment_mesh(inputs["garment_mesh"][garment])
    demos = inputs["seed_demos"][garment]
    task = read_task(demos / "task.json")
    folders = episode_folders(demos)
    if not folders:
        raise BadInput(f"{demos}/episodes: empty; the arms' starting pose is taken from the first demonstration")
    first = read_episode(folders[0])
    garment_m = read_start(demos)
    try:
        numerics = CellConfig(**first.about["cell"])
    except (KeyError, TypeError, ValueError) as error:
        raise BadInput(
            f"{folders[0]}/episode.json: no readable settings of the cell ({error!r}); make it again"
        ) from error

    def decide(history: np.ndarray) -> tuple[bool, str | None, Mapping[str, float]]:
        judgement = judge(history, mesh.faces, task)
        return bool(judgement.success), judgement.failure, judgement.figures

    scene = read_scene(inputs["scene"][garment])

    def look(garment_m: np.ndarray) -> np.ndarray:
        return render_head_view(garment_m, mesh.faces, scene, width=160, height=120)

    world = REALITY if trials_in == "reality" and read_world(inputs["reality"][garment]) else SIMULATOR
    source = "reality" if world == REALITY else "calibrated_physics"
    physics = read_physics(inputs[source][garment] / "cell.yaml")
    if world == REALITY:
        numerics = replace(numerics, substeps=FINER * numerics.substeps)
    cell = Cell(mesh, scene, physics, numerics)
    start = Start(garment_m=garment_m, joints_rad=first.joints_rad[0], openness=first.openness[0])
    return Bench(world=world, cell=cell, start=start, judge=decide, look=look)
