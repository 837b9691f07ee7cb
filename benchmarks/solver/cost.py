"""Cost of a step at equal vertices and iterations: SolverAVBD against SolverVBD, in turns, replayed from a graph."""

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.solver import contestants, scenes
from benchmarks.solver.newton_run import NewtonRun, now_s
from benchmarks.solver.stretch import rounded

KINDS = ("SolverAVBD", "SolverVBD")
FLAT = "SolverAVBD, vertices alone"
STEPS_PER_S = 600
PAIRS = 8  # of steps per measurement: 16 steps, a frame of the cell
ROUNDS = 7


def without_contact(count: int = 40, iterations: int = 10, rounds: int = ROUNDS, device: str = "cpu") -> dict[str, Any]:
    """The pulled sheet of `count` x `count` vertices after a tenth of a second of being pulled by each."""
    cloth = scenes.square(count)
    runs = []
    for kind in (*KINDS, FLAT):
        run = newton_pull(kind, cloth, iterations, device=device)
        run.advance(30)
        runs.append(run)
    seconds = in_turns([lambda run=run: measured(run) for run in runs], rounds)
    found = document("pulled sheet", cloth, iterations, seconds[:2])
    found["ratio_vertices_alone"] = document("", cloth, iterations, [seconds[2], seconds[1]])["ratio"]
    return found


def with_contact(
    count: int = 32, iterations: int = 10, rounds: int = 5, settle_s: float = 0.6, device: str = "cpu"
) -> dict[str, Any]:
    """A sheet folded over itself on a table, settled; lying there, and sliding at 0.5 m/s.

    Both start every measurement from the same positions and build their search trees anew first, as the cell does once in 16
    steps; that is counted. Contacts with the table are found once, before: finding them is newton's, the same for both.
    """
    import newton

    layers = contestants.Layers(rest_exclusion_m=min(0.006, 0.9 * scenes.EXTENT_M / (count - 1)))
    cloth = scenes.folded(count, gap_m=0.005)
    found: dict[str, Any] = {}
    runs, points = {}, cloth.start_m
    for kind in (*KINDS, FLAT):
        model = scenes.newton_model(cloth, table=True, device=device)
        pipeline = newton.CollisionPipeline(model, soft_contact_gap=0.005)
        contacts = pipeline.contacts()
        solver = contestants.newton_solver(kind, model, iterations, layers)
        run = NewtonRun(model, solver, 1.0 / STEPS_PER_S, (), contacts=contacts)
        run.place(points)
        if kind == "SolverAVBD":
            for _ in range(round(settle_s * STEPS_PER_S / (2 * PAIRS))):
                pipeline.collide(run.states[0], contacts)
                solver.rebuild_bvh()
                run.advance(PAIRS)
            points = run.points()
        run.place(points)
        pipeline.collide(run.states[0], contacts)
        runs[kind] = run
    for name, velocity in (("lying", None), ("sliding", np.array([0.5, 0.0, 0.0]))):
        measures = [lambda run=run, v=velocity: replaced(run, points, v) for run in runs.values()]
        seconds = in_turns(measures, rounds)
        found[name] = document(f"folded sheet, {name}", cloth, iterations, seconds[:2])
        found[name]["ratio_vertices_alone"] = document("", cloth, iterations, [seconds[2], seconds[1]])["ratio"]
    gaps = facing_gaps_m(points, count)
    found["layers"] = {
        "radius_m": layers.radius_m,
        "search_m": layers.search_m,
        "median_gap_m": round(float(np.median(gaps)), 5),
        "vertices_within_search": round(float((gaps < layers.search_m).mean()), 3),
        "pairs_found_by_SolverAVBD": int(runs["SolverAVBD"].solver._layers.count.numpy()[0]),
    }
    return found


def newton_pull(kind: str, cloth: scenes.Cloth, iterations: int, worlds: int = 1, device: str = "cpu") -> NewtonRun:
    """The pull of `worlds` copies of a cloth, recorded."""
    model = scenes.newton_model(cloth, worlds=worlds, device=device)
    solver = contestants.newton_solver(kind, model, iterations)
    return NewtonRun(model, solver, 1.0 / STEPS_PER_S, scenes.held_in(cloth, worlds))


def measured(run: NewtonRun, pairs: int = PAIRS) -> float:
    """Seconds per step over the next 2 `pairs` steps."""
    before = run.seconds
    run.advance(pairs)
    return (run.seconds - before) / (2 * pairs)


def replaced(run: NewtonRun, points: np.ndarray, velocity: np.ndarray | None) -> float:
    """Seconds per step from these positions on, trees built anew."""
    run.place(points, velocity)
    began = now_s(run.model.device)
    if type(run.solver).__name__ == "SolverVBD":
        run.solver.rebuild_bvh(run.states[0])
    else:
        run.solver.rebuild_bvh()
    run.advance(PAIRS)
    return (now_s(run.model.device) - began) / (2 * PAIRS)


def in_turns(measures: list[Callable[[], float]], rounds: int) -> list[list[float]]:
    """Seconds of each, measured one after the other `rounds` times so that a busy machine hits all."""
    seconds: list[list[float]] = [[] for _ in measures]
    for _ in range(rounds):
        for taken, measure in zip(seconds, measures, strict=True):
            taken.append(measure())
    return seconds


def document(what: str, cloth: scenes.Cloth, iterations: int, seconds: list[list[float]]) -> dict[str, Any]:
    """Medians and the median of the ratios of turns."""
    ours, theirs = (np.array(taken) for taken in seconds)
    return {
        "what": what,
        "vertices": len(cloth.rest_m),
        "iterations": iterations,
        "seconds_per_step_SolverAVBD": rounded(float(np.median(ours)), 3),
        "seconds_per_step_SolverVBD": rounded(float(np.median(theirs)), 3),
        "ratio": rounded(float(np.median(ours / theirs)), 3),
    }


def facing_gaps_m(points: np.ndarray, count: int) -> np.ndarray:
    """Heights between vertices of the upper layer and those below them, away from the crease."""
    rows = points.reshape(count, count, 3)
    away = count // 4
    return np.abs(rows[:, :away, 2] - rows[:, ::-1, 2][:, :away])
