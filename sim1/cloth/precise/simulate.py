"""Simulate a scene in one world, or in one and its twins."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.cloth.precise.arrays import PULL_DAMPING, PULL_STIFFNESS, TABLE_Z
from sim1.cloth.precise.compiled_code import one_compiles
from sim1.cloth.precise.march import march
from sim1.cloth.precise.pull import Pull
from sim1.cloth.precise.rest import rest
from sim1.cloth.precise.scene import Scene
from sim1.cloth.precise.world import World, pack

RESTING_M_S2 = 1e-4  # nothing accelerates by more where a sheet is called at rest
NEWTON_M = 1e-6  # last change of a step's iteration; what is left unsolved is taken out of the twins
ROUNDS, TABLE_ROUNDS = 1, 2  # of the twins' iteration with the base's factor, which is less exact where cloth rubs


class NotConverged(RuntimeError):
    """No rest or no next state was found: a material or a motion that the sheet cannot follow."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """What a simulation gives: base first, then twins."""

    markers_m: np.ndarray  # (P, N, M, 3) at the frames of the recording, as the cameras report them
    shapes_m: np.ndarray  # (T, V, 3) of the base at the steps
    pull_n: np.ndarray  # (T, M, 3) forces that pulled the base's markers
    rest_m: np.ndarray  # (V, 3) of the base
    leads_m: np.ndarray  # (P - 1, T, V, 3) of the twins, single precision; (0, T, V, 3) if nobody asked


def simulate(
    scene: Scene,
    worlds: list[World],
    *,
    near: np.ndarray | None = None,
    pull: Pull | None = None,
    guess: np.ndarray | None = None,
    leads: bool = False,
    halvings: int = 2,
) -> Run:
    """Follow the drives from rest (or from the recording's own start) in the first world; the others are its twins.

    Twins differ little from the base: they are linear answers to a change. `near` (V, 3) is a shape close to the base's rest,
    `guess` (T, V, 3) are shapes close to its motion: with them it takes fewer iterations.

    Raises:
        NotConverged: no rest, or no next state even with the step halved `halvings` times.
    """
    with one_compiles(Path(__file__).parent):
        return _simulated(scene, worlds, near, pull, guess, leads, halvings)


def _simulated(
    scene: Scene,
    worlds: list[World],
    near: np.ndarray | None,
    pull: Pull | None,
    guess: np.ndarray | None,
    leads: bool,
    halvings: int,
) -> Run:
    cloth = pack(scene.sheet, worlds, scene.clamped, scene.rim)
    count, steps = len(worlds), len(scene.time_s)
    paths = np.ascontiguousarray(np.stack([scene.paths(world) for world in worlds]))
    turns = np.stack([grip.turn for grip in scene.grips], axis=1) if scene.grips else np.zeros((steps, 0, 3, 3))
    held_on = np.stack([grip.active for grip in scene.grips], axis=1) if scene.grips else np.zeros((steps, 0), bool)
    held_on = np.ascontiguousarray(held_on[:, scene.net.grip])
    markers = len(scene.net.marker_node)
    goals = np.full((count, steps, markers, 3), np.nan)
    speeds = goals
    if pull is not None:
        kg = np.array([world.area_density_kg_m2 for world in worlds]) * scene.sheet.face_area_m2.sum() / markers
        cloth.scalar[:, PULL_STIFFNESS] = kg * pull.rate_1_s**2
        cloth.scalar[:, PULL_DAMPING] = 2.0 * kg * pull.rate_1_s
        goals, speeds = pull.goals.at(scene.time_s, worlds)
    x0 = np.repeat((scene.start if near is None else near)[None], count, axis=0)
    v0 = np.zeros_like(x0)
    if scene.start_velocity is None:
        _place_held(x0[0], scene, paths[0, 0], held_on[0])
        start = np.ascontiguousarray(paths[:, 0]), held_on[0], RESTING_M_S2
        if not rest(x0, scene.net, cloth, *start, np.ascontiguousarray(goals[:, 0])):
            raise NotConverged(f"recording {scene.name}: the sheet finds no rest at the start")
    else:
        for p, world in enumerate(worlds):
            x0[p], v0[p] = scene.begun(world)
            _place_held(x0[p], scene, paths[p, 0], held_on[0])
            _place_held(v0[p], scene, (paths[p, 1] - paths[p, 0]) / scene.step_s, held_on[0])
    for halving in range(halvings + 1):
        result = _march(scene, cloth, x0, v0, paths, turns, held_on, goals, speeds, guess, leads, 2**halving)
        guess = None
        if not isinstance(result, int):
            shapes, markers, forces, told = result
            reported = np.stack([scene.observed(path, world) for path, world in zip(markers, worlds, strict=True)])
            return Run(markers_m=reported, shapes_m=shapes, pull_n=forces, rest_m=x0[0], leads_m=told)
    at = scene.time_s[0] + result * scene.step_s / 2**halvings
    raise NotConverged(f"recording {scene.name}: no next state at {at:.3f} s; does a drive jump there?")


def _place_held(x: np.ndarray, scene: Scene, target: np.ndarray, held_on: np.ndarray) -> None:
    x[scene.net.held[held_on]] = target[held_on]


def _march(scene: Scene, cloth, x0, v0, paths, turns, held_on, goals, speeds, guess, leads, parts: int):
    """March with the step cut into `parts`; the step that failed, or shapes, markers and forces at the scene's steps."""
    count, markers = x0.shape[0], len(scene.net.marker_node)
    parts_of = (part if part is None else part.copy() for part in cloth)  # twins are brought nearer in place
    cloth, paths = type(cloth)(*parts_of), paths.copy()
    goals, speeds = goals.copy(), speeds.copy()
    if parts > 1:
        fine = np.arange(parts * (paths.shape[1] - 1) + 1) / parts
        paths, turns = _between(paths, fine, 1), _between(turns, fine, 0)
        held_on = held_on[np.round(fine).astype(int)]
        goals, speeds = _between(goals, fine, 1), _between(speeds, fine, 1)
    total = paths.shape[1]
    shapes = np.empty((total, *x0.shape[1:]))
    seen, forces = np.empty((count, total, markers, 3)), np.zeros((total, markers, 3))
    told = np.zeros((count - 1 if leads else 0, total, *x0.shape[1:]), np.float32)
    failed = march(
        x0,
        v0,
        scene.step_s / parts,
        scene.net,
        cloth,
        paths,
        turns,
        held_on,
        ROUNDS if np.isnan(cloth.scalar[0, TABLE_Z]) else TABLE_ROUNDS,
        NEWTON_M,
        goals,
        speeds,
        np.zeros((0, *x0.shape[1:])) if guess is None else guess,
        shapes,
        seen,
        forces,
        told,
    )
    if failed:
        return int(failed)
    return shapes[::parts], seen[:, ::parts], forces[::parts], told[:, ::parts]


def _between(values: np.ndarray, at: np.ndarray, axis: int) -> np.ndarray:
    low = np.floor(at).astype(int)
    high = np.minimum(low + 1, values.shape[axis] - 1)
    share = (at - low).reshape([-1 if k == axis else 1 for k in range(values.ndim)])
    return np.ascontiguousarray(values.take(low, axis) * (1 - share) + values.take(high, axis) * share)
