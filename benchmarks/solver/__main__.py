"""Run the whole comparison, print it, write `benchmarks/solver.json` and `benchmarks/solver.png`."""

import json
import os
import time
from pathlib import Path
from typing import Any

from benchmarks.solver import cost, equal, gpu, growth, picture, scenes
from benchmarks.solver.contestants import Contestant
from benchmarks.solver.stretch import LIMIT, LIMIT_P99, Pull, pull

HERE = Path(__file__).parents[1]
PULL_S = 0.5
COARSE = (
    Contestant(kind="SolverAVBD", iterations=5),
    Contestant(kind="SolverAVBD, vertices alone", iterations=5),
    Contestant(kind="SolverVBD", iterations=5),
    Contestant(kind="SolverVBD", iterations=50),
    Contestant(kind="SolverStyle3D", iterations=5),
    Contestant(kind="MuJoCo elastic"),
    Contestant(kind="MuJoCo edges"),
    Contestant(kind="MuJoCo edges 0.99"),
    Contestant(kind="MuJoCo edges 0.9999"),
)
FINE = (
    Contestant(kind="SolverAVBD", iterations=10),
    Contestant(kind="SolverAVBD, vertices alone", iterations=10),
    Contestant(kind="SolverVBD", iterations=10),
    Contestant(kind="SolverVBD", iterations=100),
    Contestant(kind="SolverStyle3D", iterations=10),
    Contestant(kind="MuJoCo elastic"),
    Contestant(kind="MuJoCo edges 0.99"),
    Contestant(kind="MuJoCo edges 0.9999"),
)
SHIRT = (
    Contestant(kind="SolverAVBD", iterations=10),
    Contestant(kind="SolverAVBD, vertices alone", iterations=10),
    Contestant(kind="SolverVBD", iterations=10),
    Contestant(kind="SolverVBD", iterations=100),
    Contestant(kind="SolverStyle3D", iterations=10),
    Contestant(kind="MuJoCo edges 0.9999"),
)
LONG_S = {"sheet 40 x 40": 0.2, "shirt": 0.05}  # of SolverVBD at 100 iterations, up to a second per step
SIDE_BY_SIDE = ("SolverAVBD, 5 it.", "SolverVBD, 5 it.", "SolverStyle3D, 5 it.", "MuJoCo elastic", "MuJoCo edges 0.99")
TARGETS = {
    "largest_stretch": LIMIT,
    "p99_stretch": LIMIT_P99,
    "cost_ratio_without_self_contact": 0.3,
    "cost_ratio_with_self_contact": 0.5,
    "time_ratio_at_equal_stretch": 0.1,
}


def main() -> None:
    """Measure, print, write."""
    began = time.monotonic()

    def say(text: str) -> None:
        print(f"[{time.monotonic() - began:5.0f} s] {text}", flush=True)

    document, shapes = measure(say)
    (HERE / "solver.json").write_text(json.dumps(document, indent=1) + "\n")
    picture.draw(document, shapes, HERE / "solver.png")
    say("written: benchmarks/solver.json, benchmarks/solver.png")


def measure(say: Any) -> tuple[dict[str, Any], list[tuple[Pull, scenes.Cloth]]]:
    """Everything but the writing."""
    pulls, shapes = [], []
    sheet, fine, shirt = scenes.square(20), scenes.square(40), scenes.shirt()
    for cloth, contestants in ((sheet, COARSE), (fine, FINE), (shirt, SHIRT)):
        for contestant in contestants:
            simulated_s = LONG_S[cloth.name] if contestant.iterations >= 100 else PULL_S
            result = pull(contestant, cloth, simulated_s)
            say(
                f"{cloth.name}, {contestant.name}: largest {result.largest:.4f}, p99 {result.p99:.4f}, "
                f"{1e3 * result.seconds_per_step:.3g} ms per step"
            )
            pulls.append(result.document())
            if cloth is sheet and contestant.name in SIDE_BY_SIDE:
                shapes.append((result, cloth))
    document: dict[str, Any] = {
        "schema": "sim1.benchmarks.solver/1",
        "machine": {"cores": os.cpu_count()},
        "seconds": "of the processor, one thread, steps alone; processes side by side: of the clock",
        "targets": TARGETS,
        "cloth": {
            "lame_moduli_n_m": scenes.MODULUS_N_M,
            "bending_rigidity_n_m": scenes.RIGIDITY_N_M,
            "density_kg_m2": {cloth.name: cloth.density_kg_m2 for cloth in (sheet, fine, shirt)},
        },
        "not_alike": NOT_ALIKE,
        "pull": pulls,
    }
    document["cost"] = {"without_self_contact": cost.without_contact()}
    say(f"cost of a step without self-contact: {document['cost']['without_self_contact']['ratio']}")
    document["cost"]["with_self_contact"] = found = cost.with_contact()
    say(f"cost of a step with self-contact: lying {found['lying']['ratio']}, sliding {found['sliding']['ratio']}")
    document["equal_stretch"] = [equal.search(sheet, say), equal.search(fine, say, iterations=(1,), first_rate=7200)]
    for cloth, search in zip((sheet, fine), document["equal_stretch"], strict=True):
        say(f"time at equal stretch, {cloth.name}: {search['ratio']}, stricter limit: {search['ratio_stricter']}")
    document["growth"] = {"vertices": growth.with_vertices()}
    say("growth with vertices measured")
    document["growth"]["worlds"] = growth.with_worlds()
    document["growth"]["processes"] = growth.with_processes()
    say(f"processes side by side: {document['growth']['processes']}")
    document["shirt_with_self_contact_cpu"] = gpu.shirt_frames("cpu", frames=2)
    say(f"shirt with self-contact: {document['shirt_with_self_contact_cpu']}")
    return document, shapes


NOT_ALIKE = {
    "SolverStyle3D": "warp, weft and shear moduli 3m, 3m, m of both Lame moduli m: no coupling of warp and weft; 10 linear "
    "iterations each; quadratic bending of the same rigidity; launched from Python, its steps cannot be recorded on a CPU",
    "MuJoCo elastic": "same mesh, mass (spread evenly over vertices), plane-stress modulus and Poisson ratio, bending rigidity; "
    "integrator discrete; pulled in the frame of the corner",
    "MuJoCo edges": "same mesh and mass; no membrane and no bending: every edge is held at its length both ways, by a soft constraint "
    "with MuJoCo's defaults, or (0.99, 0.9999: largest impedance) with a time constant of two steps; each step is solved to the end",
}


if __name__ == "__main__":
    main()
