"""Closed-loop trials: the garment is laid down anew, the policy drives, the judge decides."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from sim1.cloth.cell import Cell, CellConfig, SimulationBroke
from sim1.cloth.effects.anisotropic_friction import AnisotropicFriction
from sim1.cloth.garment import read_garment_mesh
from sim1.cloth.physics import ClothPhysics, read_physics
from sim1.episode import RATE_HZ, episode_folders, read_episode, read_start
from sim1.film_strip import HEIGHT, WIDTH, FilmStrip, Look, film_strip, laid_down
from sim1.motion.placement import random_placement
from sim1.policy.lessons import NAMES, ModelKey
from sim1.policy.model import ChunkPolicy
from sim1.policy.rollout import Driving, Pilot, Start, StatePilot, roll_out
from sim1.policy.time_limit import TimeLimit
from sim1.policy.worlds import REALITY, SIMULATOR
from sim1.quota import Ticket
from sim1.recording.reality import read_world
from sim1.robot.expert_task import read_task
from sim1.robot.session import settle
from sim1.robot.stage import RealDemosConfig
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Inputs, random_stream
from sim1.validity.raster import render_head_view
from sim1.validity.success import judge

TRIAL_COLUMNS = (
    "world", "trained_on", "size", "seed", "garment", "shift", "trial", "success", "failure", "figures",
    "shift_x_m", "shift_y_m", "turn_rad", "friction_factor", "simulated_s",
)  # fmt: skip
BROKEN = "simulation broke"  # the judge's word for it
RUBBED = ("friction", "texture")  # shifts in which friction of all contacts is another
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
    look: Look


@dataclass(frozen=True, kw_only=True)
class Trial:
    """Who drives what, and from where."""

    model: ModelKey
    garment: str
    shift: str
    number: int

    @property
    def series(self) -> str:
        """All trials of a model in one setting."""
        return "_".join(map(str, (self.garment, self.shift, *self.model)))

    @property
    def name(self) -> str:
        """Of its file (`sim1.quota.Ticket`)."""
        return Ticket(series=self.series, number=self.number).name

    def friction_factor(self, config: "Laying") -> float:
        """Of all contacts, against the world as it is."""
        factors = config.friction_factors
        return factors[self.number % len(factors)] if self.shift in RUBBED else 1.0


class Laying(Protocol):
    """Settings that say how the garment is laid down in trials, of whatever stage makes them (`PolicyConfig` explains them)."""

    seed: int
    laid_m: float
    shift_m: float
    turn_rad: float
    friction_factors: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class TrialSettings:
    """What all trials share."""

    driving: Driving
    limits: Mapping[str, TimeLimit]  # by garment
    config: Laying


def run_trial(
    bench: Bench, trial: Trial, model: ChunkPolicy, keypoints: np.ndarray, settings: TrialSettings
) -> tuple[dict[str, Any], FilmStrip]:
    """The row (`TRIAL_COLUMNS`) and the pictures of a trial of a state policy."""
    row, history_m = drive(bench, trial, StatePilot(model, trial.garment, keypoints), settings)
    return row, film_strip(title_of(row), history_m, bench.look)


def drive(bench: Bench, trial: Trial, pilot: Pilot, settings: TrialSettings) -> tuple[dict[str, Any], np.ndarray]:
    """The trial's row (`TRIAL_COLUMNS`) and the garment over time (T, v, 3).

    Placements belong to a network's seed and the trial's number: those of one seed meet the same ones whatever they learnt from,
    in every variant, so that they compare in pairs; those of another seed meet others, so that trials add up.
    """
    config, centre = settings.config, bench.start.garment_m.mean(axis=0)
    spatial = trial.shift == "spatial"
    radius_m, turn_rad = (config.shift_m, config.turn_rad) if spatial else (config.laid_m, 0.0)
    stream = random_stream(config.seed, "trial", trial.garment, trial.model.seed, trial.number)
    placement = random_placement(stream, radius_m, turn_rad, centre)
    moved = bench.start.garment_m @ placement[:3, :3].T + placement[:3, 3]
    start = Start(garment_m=moved, joints_rad=bench.start.joints_rad, openness=bench.start.openness)
    duration_s, history = settings.limits[trial.garment].duration_s, []
    try:
        for garment_m in roll_out(bench.cell, start, pilot, settings.driving, duration_s):
            history.append(garment_m)
        # The task's fold lines lie along the world's axes: judged as if the garment had not been moved, a turned
        # garment that is folded along its own axes counts as folded.
        success, failure, figures = bench.judge((np.stack(history) - placement[:3, 3]) @ placement[:3, :3])
    except SimulationBroke:
        success, failure, figures, duration_s = False, BROKEN, {}, bench.cell.frame / RATE_HZ
    shift = moved.mean(axis=0) - centre
    row = {
        "world": bench.world,
        **trial.model._asdict(),
        "garment": trial.garment,
        "shift": trial.shift,
        "trial": trial.number,
        "success": success,
        "failure": failure,
        "figures": json.dumps({key: float(value) for key, value in sorted(figures.items())}),
        "shift_x_m": float(shift[0]),
        "shift_y_m": float(shift[1]),
        "turn_rad": float(np.arctan2(placement[1, 0], placement[0, 0])),
        "friction_factor": trial.friction_factor(config),
        "simulated_s": duration_s,
    }
    return row, np.stack(history)


def title_of(row: Mapping[str, Any]) -> str:
    """Who drove, and where the garment lay."""
    rubbing = f", friction × {row['friction_factor']:g}" if row["friction_factor"] != 1.0 else ""
    return (
        f"{row['garment']}, after {row['size']} {NAMES[row['trained_on']]}, network seed {row['seed']}, trial {row['trial']}, "
        f"{laid_down(row['shift_x_m'], row['shift_y_m'], row['turn_rad'])}{rubbing}"
    )


def open_bench(inputs: Inputs, garment: str, trials_in: str, friction_factor: float = 1.0) -> Bench:
    """A cell with a garment as the expert found it there, and the judge of its task.

    In `reality` fabric, effects and friction are those of the stand-in, which no stage that made training data has seen, at finer
    steps and on a finer mesh, and the garment lies as that fabric does. Where reality is real cloth, and in `simulator`, it is the cell that the
    training data come from. Friction of all contacts is taken times `friction_factor`, after the garment was laid down.

    Raises:
        BadInput: an artifact of that garment is missing or damaged.
    """
    for name in ("garment_mesh", "scene", "calibrated_physics", "seed_demos", "reality", "real_demos"):
        if garment not in inputs.get(name, {}):
            raise BadInput(f"stage input {name!r}: none for garment {garment!r}; materialize it first")
    mesh = read_garment_mesh(inputs["garment_mesh"][garment])
    demos = inputs["seed_demos"][garment]
    task = read_task(demos / "task.json")
    folders = episode_folders(demos)
    if not folders:
        raise BadInput(f"{demos}/episodes: empty; the arms' starting pose is taken from the first demonstration")
    first = read_episode(folders[0])
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
        return render_head_view(garment_m, mesh.faces, scene, width=WIDTH, height=HEIGHT)

    world = REALITY if trials_in == "reality" and read_world(inputs["reality"][garment]) else SIMULATOR
    source = "reality" if world == REALITY else "calibrated_physics"
    physics = read_physics(inputs[source][garment] / "cell.yaml")
    if world == REALITY:
        numerics = replace(numerics, substeps=FINER * numerics.substeps, finer_mesh=True)
        where = f"{inputs['garment_mesh'][garment]} in {inputs['scene'][garment]}"
        garment_m = _start_in_reality(
            inputs["real_demos"][garment], lambda: Cell(mesh, scene, physics, numerics), where
        )
    else:
        garment_m = read_start(demos)
    cell = Cell(mesh, scene, rubbed(physics, friction_factor), numerics)
    start = Start(garment_m=garment_m, joints_rad=first.joints_rad[0], openness=first.openness[0])
    return Bench(world=world, cell=cell, start=start, judge=decide, look=look)


def _start_in_reality(demos: Path, make_cell: Callable[[], Cell], where: str) -> np.ndarray:
    """The garment (v, 3) m as real demonstrations began; where it was not demonstrated, settled in the same way in a cell of that world."""
    if not (demos / "none.json").exists():
        return read_start(demos)
    usual = RealDemosConfig()
    try:
        return settle(make_cell(), longest_s=usual.settle_s, rest_speed_m_s=usual.rest_speed_m_s).astype(float)
    except BadInput as error:
        raise BadInput(f"{where}: {error}") from error


def rubbed(physics: ClothPhysics, factor: float) -> ClothPhysics:
    """The same fabric with friction of all contacts times a factor; an effect may say what the table's is along either axis."""
    if factor == 1.0:
        return physics
    known = physics.friction
    contacts = {name: replace(one, value=factor * one.value, ci95=None) for name, one in vars(known).items()}
    uneven = AnisotropicFriction.name
    effects = tuple(_times(one, factor) if one["name"] == uneven else one for one in physics.effects)
    return replace(physics, friction=replace(known, **contacts), effects=effects)


def _times(effect: dict[str, Any], factor: float) -> dict[str, Any]:
    """A model file's entry of an effect with all of its parameters times a factor."""
    parameters = {
        name: {**one, "value": factor * one["value"], "ci95": None} for name, one in effect["parameters"].items()
    }
    return {**effect, "parameters": parameters}
