"""How cost and stretch grow: with vertices, with worlds in one process, with processes."""

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks.solver import scenes
from benchmarks.solver.contestants import Contestant
from benchmarks.solver.cost import KINDS, in_turns, measured, newton_pull
from benchmarks.solver.stretch import pull, rounded

SIDES = (10, 18, 32, 56, 100, 178)  # of the sheet in vertices: 10^2 to 10^4.5 vertices
STRETCH_SIDES = (10, 18, 32, 56)  # those that are pulled for half a second
ITERATIONS = 10
WORLDS = (1, 4, 16)
WORLD_SIDE = 20
VERTEX_STEPS = 40_000  # of a measurement: few steps at the large end


def with_vertices(
    sides: tuple[int, ...] = SIDES,
    stretch_sides: tuple[int, ...] = STRETCH_SIDES,
    simulated_s: float = 0.5,
    rounds: int = 3,
) -> list[dict[str, Any]]:
    """Seconds per step of both solvers and, where it is affordable, the largest stretch of the pull of SolverAVBD."""
    rows = []
    for side in sides:
        cloth = scenes.square(side)
        pairs = max(VERTEX_STEPS // (2 * side * side), 1)
        runs = [newton_pull(kind, cloth, ITERATIONS) for kind in KINDS]
        seconds = in_turns([lambda run=run, n=pairs: measured(run, n) for run in runs], rounds)
        row: dict[str, Any] = {"vertices": side * side, "iterations": ITERATIONS}
        for kind, taken in zip(KINDS, seconds, strict=True):
            row[f"seconds_per_step_{kind}"] = rounded(sorted(taken)[len(taken) // 2], 3)
        if side in stretch_sides:
            found = pull(Contestant(kind="SolverAVBD", iterations=ITERATIONS), cloth, simulated_s)
            row["largest_stretch_SolverAVBD"] = rounded(found.largest)
            row["p99_stretch_SolverAVBD"] = rounded(found.p99)
        rows.append(row)
    return rows


def with_worlds(worlds: tuple[int, ...] = WORLDS, side: int = WORLD_SIDE, rounds: int = 3) -> list[dict[str, Any]]:
    """Copies of the pull in one model: seconds per step and world."""
    cloth = scenes.square(side)
    rows = []
    for count in worlds:
        runs = [newton_pull(kind, cloth, 5, worlds=count) for kind in KINDS]
        seconds = in_turns([lambda run=run: measured(run, 10) for run in runs], rounds)
        row: dict[str, Any] = {"worlds": count, "vertices_each": side * side, "iterations": 5}
        for kind, taken in zip(KINDS, seconds, strict=True):
            row[f"seconds_per_step_and_world_{kind}"] = rounded(sorted(taken)[len(taken) // 2] / count, 3)
        rows.append(row)
    return rows


def with_processes(counts: tuple[int, ...] = (1, 2), side: int = WORLD_SIDE, pairs: int = 600) -> list[dict[str, Any]]:
    """The same pull in several processes at once: steps per second of the clock, all processes together.

    Here the clock counts: what processes take from each other is the question. Each says when it is ready, all are let go together.
    """
    rows = []
    for count in counts:
        command = [sys.executable, "-m", "benchmarks.solver.growth", str(side), str(pairs)]
        root = Path(__file__).parents[2]
        workers = [
            subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=root)
            for _ in range(count)
        ]
        try:
            for worker in workers:
                while (line := worker.stdout.readline()).strip() != "ready":
                    if not line:
                        raise RuntimeError("a process of the benchmark ended before it was ready")
            for worker in workers:
                worker.stdin.write("go\n")
                worker.stdin.flush()
            seconds = max(json.loads(worker.stdout.readline()) for worker in workers)
        finally:
            for worker in workers:
                worker.communicate()
        rows.append({"processes": count, "steps_per_second": rounded(2 * pairs * count / seconds, 3)})
    return rows


def _worker(side: int, pairs: int) -> None:
    run = newton_pull("SolverAVBD", scenes.square(side), 5)
    run.advance(10)
    print("ready", flush=True)
    sys.stdin.readline()
    began = time.perf_counter()
    run.advance(pairs)
    print(json.dumps(time.perf_counter() - began), flush=True)


if __name__ == "__main__":
    _worker(int(sys.argv[1]), int(sys.argv[2]))
