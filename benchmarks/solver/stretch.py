"""The pull: how far edges stretch while one corner is pulled away."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.solver.contestants import Contestant, Run, corner_way_m, start
from benchmarks.solver.scenes import Cloth

LIMIT = 1.06  # largest stretch asked of SolverAVBD
LIMIT_P99 = 1.055


@dataclass(frozen=True, kw_only=True)
class Pull:
    """What came of a pull."""

    contestant: Contestant
    cloth: str
    vertices: int
    simulated_s: float
    largest: float  # length over rest length of an edge, the largest of the run
    p99: float  # 99th percentile over the edges, the largest of the run
    seconds_per_step: float  # of the processor; of the clock on a GPU
    times_s: tuple[float, ...]
    stretch: tuple[float, ...]  # largest of all edges at those times
    middle_m: tuple[float, float, float]  # mean of the vertices at the end
    points_m: np.ndarray

    @property
    def seconds_per_simulated_second(self) -> float:
        """Of the processor, or of the clock on a GPU."""
        return self.seconds_per_step * self.contestant.steps_per_s

    def document(self) -> dict[str, Any]:
        """For the file."""
        return {
            "solver": self.contestant.kind,
            "iterations": None if self.contestant.kind.startswith("MuJoCo") else self.contestant.iterations,
            "steps_per_s": self.contestant.steps_per_s,
            "modulus_n_m": self.contestant.modulus_n_m,
            **({"max_strain": self.contestant.max_strain} if self.contestant.kind.startswith("SolverAVBD") else {}),
            "cloth": self.cloth,
            "vertices": self.vertices,
            "simulated_s": round(self.simulated_s, 4),
            "largest_stretch": rounded(self.largest),
            "p99_stretch": rounded(self.p99),
            "seconds_per_step": rounded(self.seconds_per_step, 3),
            "seconds_per_simulated_second": rounded(self.seconds_per_simulated_second, 3),
            "mean_height_at_end_m": round(self.middle_m[2], 4),
        }


def pull(
    contestant: Contestant, cloth: Cloth, simulated_s: float, stop_above: float = np.inf, device: str = "cpu"
) -> Pull:
    """Pull `cloth` for `simulated_s`; stop at once when an edge is longer than `stop_above` times its rest length."""
    run = start(contestant, cloth, device)
    return watch(run, contestant, cloth, simulated_s, stop_above)


def watch(run: Run, contestant: Contestant, cloth: Cloth, simulated_s: float, stop_above: float = np.inf) -> Pull:
    """Measure the edges of a run about 300 times a second or after every second step."""
    edges, rest = cloth.edges, cloth.edge_length_m
    times, stretch, largest_p99 = [], [], 0.0
    look_every = max(contestant.steps_per_s // 600, 1)
    dt_s = 1.0 / contestant.steps_per_s
    for pair in range(1, round(0.5 * simulated_s / dt_s) + 1):
        run.advance()
        if pair % look_every:
            continue
        points = run.points()
        ratio = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1) / rest
        times.append(run.steps * dt_s)
        stretch.append(float(ratio.max()))
        largest_p99 = max(largest_p99, float(np.percentile(ratio, 99)))
        if not ratio.max() <= stop_above:
            break
    points = run.points()
    if np.isfinite(points).all():
        _check_corner(points, cloth, run.steps * dt_s)
    middle = points.mean(axis=0)
    return Pull(
        contestant=contestant,
        cloth=cloth.name,
        vertices=len(cloth.rest_m),
        simulated_s=run.steps * dt_s,
        largest=max(stretch),
        p99=largest_p99,
        seconds_per_step=run.seconds / run.steps,
        times_s=tuple(times),
        stretch=tuple(stretch),
        middle_m=(float(middle[0]), float(middle[1]), float(middle[2])),
        points_m=points,
    )


def rounded(value: float, digits: int = 4) -> float | None:
    """With `digits` significant digits; None where it is no number, which JSON does not know."""
    return float(f"{value:.{digits}g}") if np.isfinite(value) else None


def _check_corner(points: np.ndarray, cloth: Cloth, time_s: float) -> None:
    wanted = cloth.start_m[list(cloth.held)] + np.array([corner_way_m(time_s), 0.0, 0.0])
    apart = np.abs(points[list(cloth.held)] - wanted).max()
    if apart > 2e-3:
        raise AssertionError(f"the held corner is {1e3 * apart:.1f} mm from its path: the pulls would not be alike")
