"""Simulates all recordings of a bundle in any world, on two meshes, with slopes; recordings side by side in threads."""

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.precise.scene import Scene, prepare
from sim1.cloth.precise.simulate import NotConverged, simulate
from sim1.cloth.precise.world import World
from sim1.mismatch.compare import Observed, block_noise_m, mesh_error, observe
from sim1.mismatch.search import Unknowns
from sim1.recording.bundle import Bundle

COARSE_S, FINE_S = 1 / 120, 1 / 240  # steps: at 1/60 s a fast swing comes out millimetres wrong
EXTRAPOLATE = 1 / 3  # what is still missing on the finer mesh, in units of what refining changed: second order
WOBBLE_Z = 0.03  # in prior standard deviations: what the simulator itself is taken to be wrong by


@dataclass
class _Stage:
    """One recording: its two scenes, its data, and what was learnt from the last runs."""

    coarse: Scene
    fine: Scene
    observed: Observed
    defect_m: np.ndarray | float = 0.0  # (N, M, 3) added to what the coarse mesh says
    rest_m: np.ndarray | None = None
    fine_rest_m: np.ndarray | None = None


class Engine:
    """The recordings of a bundle, ready to be simulated."""

    def __init__(self, bundle: Bundle, *, noise_m: float | None = None, threads: int | None = None):
        self.bundle = bundle
        observed = [observe(recording) for recording in bundle.recordings]
        noise = block_noise_m(observed, list(bundle.recordings)) or noise_m or 1e-3
        self.noise_m = noise
        self.stages = {
            recording.name: _Stage(
                coarse=prepare(bundle, recording, COARSE_S),
                fine=prepare(bundle, recording, FINE_S, finer=1),
                observed=replace(one, noise_m=noise),
            )
            for recording, one in zip(bundle.recordings, observed, strict=True)
        }
        self._pool = ThreadPoolExecutor(threads or min(2, os.cpu_count() or 1))
        self.coarse_runs = self.fine_runs = self.twin_runs = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Recordings in the order of the bundle."""
        return tuple(self.stages)

    def observed(self, name: str) -> Observed:
        """Data of a recording."""
        return self.stages[name].observed

    def refine(self, world: World, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Measure anew what the coarse mesh gets wrong in `world`; markers (N, M, 3), extrapolated."""

        def one(name: str) -> np.ndarray:
            stage = self.stages[name]
            fine = simulate(stage.fine, [world], near=stage.fine_rest_m)
            coarse = simulate(stage.coarse, [world], near=stage.rest_m)
            stage.fine_rest_m, stage.rest_m = fine.rest_m, coarse.rest_m
            change = fine.markers_m[0] - coarse.markers_m[0]
            stage.defect_m = (1 + EXTRAPOLATE) * change
            stage.observed = replace(stage.observed, mesh_m=mesh_error(stage.observed, change))
            return coarse.markers_m[0] + stage.defect_m

        self.fine_runs += len(names)
        return dict(zip(names, self._pool.map(one, names), strict=True))

    def soften(self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...]) -> None:
        """Trust a number less the more it hangs on the baseline's coefficients: where a sheet snaps, no simulator foretells it.

        A simulator that is wrong by `WOBBLE_Z` in each of them is wrong by so much there; added to what the mesh gets wrong.
        """
        columns = list(range(len(unknowns.nominal)))
        _, slopes = self.slopes(unknowns, z, names, columns)
        for name in names:
            stage = self.stages[name]
            one = stage.observed
            wobble = WOBBLE_Z * np.linalg.norm(slopes[name], axis=1) * one.sigma_m
            stage.observed = replace(one, mesh_m=np.hypot(one.mesh_m, wobble))

    def markers(self, world: World, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Markers (N, M, 3) on the coarse mesh, corrected by what refining changed."""
        return {name: run[0] for name, run in self._run([world], names).items()}

    def residuals(self, world: World, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Simulated less measured in units of its standard deviation, (K,) per recording."""
        return {name: self._units(name, run) for name, run in self.markers(world, names).items()}

    def slopes(
        self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...], columns: list[int] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Residuals (K,) and their derivatives (K, columns) over z."""
        columns = list(range(len(z))) if columns is None else columns
        low, high = unknowns.bounds()
        worlds, steps = [unknowns.world(z)], []
        for k in columns:
            away = unknowns.all[k].twin_z
            step = away if z[k] + away <= high[k] and (z[k] <= 0 or z[k] - away < low[k]) else -away
            moved = z.copy()
            moved[k] += step
            worlds.append(unknowns.world(moved))
            steps.append(step)
        return self.answers(worlds, np.array(steps), names)

    def answers(
        self, worlds: list[World], steps: np.ndarray, names: tuple[str, ...]
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Residuals of the first world, and how they change, per unit, towards each of the others."""
        residuals, slopes = {}, {}
        for name, run in self._run(worlds, names).items():
            one = self.stages[name].observed
            lead = one.reduce(run[1:] - run[0]) / one.sigma_m
            residuals[name], slopes[name] = self._units(name, run[0]), (lead / steps[:, None]).T
        return residuals, slopes

    def _units(self, name: str, markers: np.ndarray) -> np.ndarray:
        one = self.stages[name].observed
        return (one.reduce(markers) - one.measured_m) / one.sigma_m

    def _run(self, worlds: list[World], names: tuple[str, ...]) -> dict[str, np.ndarray]:
        def one(name: str) -> np.ndarray:
            stage = self.stages[name]
            try:
                run = simulate(stage.coarse, worlds, near=stage.rest_m)
            except NotConverged:  # perhaps from where the last rest was: once more from the markers
                run = simulate(stage.coarse, worlds)
            if stage.rest_m is None:
                stage.rest_m = run.rest_m
            return run.markers_m + stage.defect_m

        self.coarse_runs += len(names)
        self.twin_runs += len(names) * (len(worlds) - 1)
        return dict(zip(names, self._pool.map(one, names), strict=True))
