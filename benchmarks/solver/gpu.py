"""Figures of a GPU where warp finds one: the shirt with self-contact, and worlds side by side. Untested where there is none."""

from typing import Any

from benchmarks.solver import contestants, scenes
from benchmarks.solver.cost import measured, newton_pull
from benchmarks.solver.newton_run import NewtonRun
from benchmarks.solver.stretch import rounded

FRAME_RATE = 60  # frames per simulated second
SUBSTEPS = 10  # of a frame: 1/600 s, what the stretch of the pull was measured with
WORLDS = (1, 16, 64, 256, 1024)
NOT_MEASURED = "not measured"


def measure() -> dict[str, Any] | str:
    """All figures, or "not measured" on a machine without a GPU."""
    import warp as wp

    wp.config.log_level = wp.LOG_ERROR
    if not wp.get_cuda_device_count():
        return NOT_MEASURED
    return {"shirt": shirt_frames("cuda:0"), "worlds": throughput("cuda:0")}


def shirt_frames(device: str, frames: int = 60, cloth: scenes.Cloth | None = None) -> dict[str, Any]:
    """Frames per second of a cloth (the shirt) with self-contact, 10 iterations; trees built anew once a frame, counted."""
    cloth = cloth or scenes.shirt()
    # Where the mesh is finer than the layers' distance, neighbours at rest are nearer than that and no contacts.
    layers = contestants.Layers(radius_m=0.002, search_m=0.004, rest_exclusion_m=0.004)
    model = scenes.newton_model(cloth, device=device)
    solver = contestants.newton_solver("SolverAVBD", model, 10, layers)
    run = NewtonRun(model, solver, 1.0 / (FRAME_RATE * SUBSTEPS), scenes.held_in(cloth, 1))
    import time

    import warp as wp

    wp.synchronize()
    began = time.perf_counter()
    for _ in range(frames):
        solver.rebuild_bvh()
        run.advance(SUBSTEPS // 2)
    wp.synchronize()
    seconds = time.perf_counter() - began
    return {
        "vertices": len(cloth.rest_m),
        "iterations": 10,
        "substeps": SUBSTEPS,
        "frames_per_second": rounded(frames / seconds, 3),
        "times_real_time": rounded(frames / seconds / FRAME_RATE, 3),
    }


def throughput(device: str, worlds: tuple[int, ...] = WORLDS, side: int = 20) -> list[dict[str, Any]]:
    """Steps of all worlds together per second, 5 iterations, without self-contact."""
    rows = []
    for count in worlds:
        run = newton_pull("SolverAVBD", scenes.square(side), 5, worlds=count, device=device)
        run.advance(5)
        seconds = sorted(measured(run, 20) for _ in range(3))[1]
        rows.append({"worlds": count, "vertices_each": side * side, "steps_per_second": rounded(count / seconds, 3)})
    return rows
