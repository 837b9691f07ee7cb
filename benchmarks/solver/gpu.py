"""The cloth solver on a GPU beside newton's `SolverVBD` there, and beside itself on that machine's processor.

`python -m benchmarks.solver.gpu` writes `benchmarks/solver_gpu.json`; all figures of it come from one run. Seconds are of the clock
on the GPU, of the processor (one thread) beside it. Steps are replayed from a graph, so that launching from Python costs nobody
anything.
"""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.solver import contestants, cost, scenes
from benchmarks.solver.contestants import Contestant
from benchmarks.solver.cost import measured, newton_pull
from benchmarks.solver.newton_run import NewtonRun, now_s
from benchmarks.solver.stretch import pull, rounded
from sim1.whole_file import whole_file

GPU = "cuda:0"
FRAME_RATE = 60  # frames per simulated second
SUBSTEPS = 10  # of a frame: 1/600 s, what the stretch of the pull was measured with
WORLDS = (1, 16, 64, 256, 1024)
PULL_S = 0.5
SIDES = (20, 40, 80, 160)


def main() -> None:
    """Measure, print, write; what is known so far is written as it comes.

    Raises:
        SystemExit: warp finds no GPU.
    """
    import warp as wp

    wp.config.log_level = wp.LOG_ERROR
    if not wp.get_cuda_device_count():
        raise SystemExit("warp finds no GPU: nothing to measure here; `python -m benchmarks.solver` needs none")
    began, path = time.monotonic(), Path(__file__).parents[1] / "solver_gpu.json"
    document: dict[str, Any] = {
        "schema": "sim1.benchmarks.solver_gpu/1",
        "gpu": wp.get_device(GPU).name,
        "versions": {"warp": wp.config.version},
        "seconds": "of the clock on the GPU, of the processor (one thread) beside it; of steps alone, replayed from a graph",
    }
    for name, measure in SECTIONS.items():
        document[name] = measure()
        with whole_file(path) as part:
            part.write_text(json.dumps(document, indent=1) + "\n")
        print(f"[{time.monotonic() - began:5.0f} s] {name}: {json.dumps(document[name])}", flush=True)


def pulls() -> list[dict[str, Any]]:
    """The pull of the comparison on the GPU, and ours on the processor: stretch is to be the same, whatever moves at once."""
    rows = []
    for cloth, iterations in ((scenes.square(20), 5), (scenes.square(40), 10), (scenes.shirt(), 10)):
        for kind, device in (("SolverAVBD", GPU), ("SolverAVBD", "cpu"), ("SolverVBD", GPU)):
            found = pull(Contestant(kind=kind, iterations=iterations), cloth, PULL_S, device=device)
            rows.append({"device": device, **found.document()})
    return rows


SECTIONS: dict[str, Callable[[], Any]] = {
    "pull": pulls,
    "cost_without_self_contact": lambda: [cost.without_contact(side, rounds=3, device=GPU) for side in SIDES],
    "cost_with_self_contact": lambda: cost.with_contact(rounds=3, device=GPU),
    "shirt_with_self_contact": lambda: {"gpu": shirt_frames(GPU), "processor": shirt_frames("cpu", frames=2)},
    "worlds": lambda: throughput(GPU),
}


def shirt_frames(device: str, frames: int = 60, cloth: scenes.Cloth | None = None) -> dict[str, Any]:
    """Frames per second of a cloth (the shirt) with self-contact, 10 iterations; trees built anew once a frame, counted."""
    cloth = cloth or scenes.shirt()
    # Where the mesh is finer than the layers' distance, neighbours at rest are nearer than that and no contacts.
    layers = contestants.Layers(radius_m=0.002, search_m=0.004, rest_exclusion_m=0.004)
    model = scenes.newton_model(cloth, device=device)
    solver = contestants.newton_solver("SolverAVBD", model, 10, layers)
    run = NewtonRun(model, solver, 1.0 / (FRAME_RATE * SUBSTEPS), scenes.held_in(cloth, 1))
    began = now_s(model.device)
    for _ in range(frames):
        solver.rebuild_bvh()
        run.advance(SUBSTEPS // 2)
    seconds = now_s(model.device) - began
    return {
        "vertices": len(cloth.rest_m),
        "iterations": 10,
        "substeps": SUBSTEPS,
        "frames_per_second": rounded(frames / seconds, 3),
        "times_real_time": rounded(frames / seconds / FRAME_RATE, 3),
    }


def throughput(device: str, worlds: tuple[int, ...] = WORLDS, side: int = 20) -> list[dict[str, Any]]:
    """Steps of all worlds together per second, 5 iterations, without self-contact; of both solvers."""
    rows = []
    for count in worlds:
        row: dict[str, Any] = {"worlds": count, "vertices_each": side * side}
        for kind in cost.KINDS:
            run = newton_pull(kind, scenes.square(side), 5, worlds=count, device=device)
            run.advance(5)
            seconds = sorted(measured(run, 20) for _ in range(3))[1]
            row[f"steps_per_second_{kind}"] = rounded(count / seconds, 3)
        rows.append(row)
    return rows


if __name__ == "__main__":
    main()
