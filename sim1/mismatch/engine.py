"""All recordings of a bundle in any world, with slopes: residuals in units of their standard deviation."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from sim1.cloth.precise.scene import Scene, prepare
from sim1.cloth.precise.simulate import NotConverged
from sim1.cloth.precise.world import World
from sim1.mismatch.compare import (
    Observed,
    mesh_error,
    noise_of_blocks_m,
    observe,
    off_by_coarser,
    off_by_finer,
)
from sim1.mismatch.patience import Patience
from sim1.mismatch.search import Unknowns
from sim1.mismatch.workers import Done, Task, Workers
from sim1.recording.bundle import Bundle
from sim1.recording.creep import creep_m

STEP_S = 1 / 60  # of searches; what it gets wrong is measured with half of it and corrected for
FINE_STEP_S = 1 / 240  # of predictions
RICHARDSON = 4 / 3  # of what half a step changes is what a step gets wrong: BDF2 is of second order
ENOUGH_VERTICES = 250  # a mesh of fewer is refined: slack sheets of 12 x 12 vertices fold millimetres off
WOBBLE_Z = 0.03  # in prior standard deviations: what the simulator itself is taken to be wrong by
ASKED = 6.0  # simulations of what is held out, beside those that measure errors: slopes, as long as three, baseline, two models
FINER = 12.0  # times the working mesh's simulation, that one of the next finer mesh takes
FOLLOW_HZ = 1.0  # how fast a simulated marker follows the measured one while models are compared

Looked = tuple[dict[str, np.ndarray], dict[str, np.ndarray]]  # residuals (K,) and slopes (K, P) by recording


@dataclass
class _Stage:
    """One recording: its scene, its data, and what was learnt from the last runs."""

    scene: Scene
    observed: Observed
    defect_m: np.ndarray | float = 0.0  # (N, M, 3) added to what the long step says
    mesh_off_m: np.ndarray | None = None  # (K,) what the mesh is taken to be off by
    finer_off_m: np.ndarray | None = None  # (K,) the same by a mesh that is finer; None: not asked yet
    rest_m: np.ndarray | None = None  # (V, 3) where it rested last


class Engine:
    """The recordings of a bundle, ready to be simulated; a context, as it owns processes."""

    projects = True  # whether shortlists take out of a fingerprint what the model can imitate; off, it shows what that is worth

    def __init__(
        self,
        bundle: Bundle,
        *,
        processes: int | None = None,
        follow_hz: float = FOLLOW_HZ,
        patience: Patience | None = None,
    ):
        self.bundle, self.follow_hz, self.patience = bundle, follow_hz, patience or Patience()
        self.workers = Workers(bundle, processes)
        observed = [observe(recording) for recording in bundle.recordings]
        noise = noise_of_blocks_m(bundle, observed)
        self.creep_m = creep = creep_m(bundle) or 0.0
        self.finer = self.finest = mesh_for(bundle)  # how often the given mesh is refined
        self.stages = {
            recording.name: _Stage(
                scene=prepare(bundle, recording, STEP_S, self.finer),
                observed=replace(one, noise_m=own, creep_m=creep),
            )
            for recording, one, own in zip(bundle.recordings, observed, noise, strict=True)
        }
        self.area_m2 = float(next(iter(self.stages.values())).scene.sheet.face_area_m2.sum())
        self.simulating_s = 0.0
        self._pace_s = dict[bool, float]()  # seconds that a step of one recording takes: on the working mesh, on others

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(self, *_) -> None:
        """End the processes."""
        self.workers.close()

    @property
    def names(self) -> tuple[str, ...]:
        """Recordings in the order of the bundle."""
        return tuple(self.stages)

    def observed(self, name: str) -> Observed:
        """Data of a recording."""
        return self.stages[name].observed

    @property
    def other_mesh(self) -> int:
        """How often the mesh is refined that says what the working one gets wrong."""
        return self.finer - 1 if self.finer else self.finer + 1

    def refine(self, world: World, names: tuple[str, ...]) -> None:
        """Measure anew what mesh and step get wrong in `world`: the mesh's error counts as noise, the step's is corrected for.

        A mesh that is finer still takes as long as a dozen of the working one, so it is asked once, where models are compared; where no
        simulation follows on it, it is taken to change as much as the working mesh did. Each number is trusted as little as the less
        trusting of both looks says.
        """
        kinds = [(self.finer, STEP_S), (self.other_mesh, STEP_S), (self.finer, STEP_S / 2)]
        runs = self.run([self._task(name, (world,), *kind) for kind in kinds for name in names])
        off_by = off_by_finer if self.other_mesh > self.finer else off_by_coarser
        asked = self._asked_further(world, names)
        for k, name in enumerate(names):
            working, other, halved = (run.markers_m[0] for run in runs[k :: len(names)])
            stage = self.stages[name]
            one = stage.observed
            stage.defect_m = RICHARDSON * (halved - working)
            if name in asked:
                run = asked[name]
                further = (working, run.markers_m[0]) if isinstance(run, Done) else (other, working)
                stage.finer_off_m = one.reduce(off_by_finer(*further))
            looks = [one.reduce(off_by(working, other))]
            if stage.finer_off_m is not None and self.finer == self.finest:
                looks.append(stage.finer_off_m)
            stage.mesh_off_m = max(looks, key=lambda off_m: float(np.square(off_m).sum()))
            stage.observed = replace(one, mesh_m=np.max([mesh_error(one, off_m) for off_m in looks], axis=0))

    def _asked_further(self, world: World, names: tuple[str, ...]) -> dict[str, Done | NotConverged]:
        """Recordings that were not asked yet on the next finer mesh; none where the given mesh is fine enough."""
        new = [name for name in names if self.stages[name].finer_off_m is None]
        if not new or not (self.finer == self.finest > 0 and self.follow_hz == FOLLOW_HZ):
            return {}
        tasks = [self._task(name, (world,), self.finer + 1, STEP_S) for name in new]
        return dict(zip(new, self.attempted(tasks), strict=True))

    @contextmanager
    def aside(self, *, stay: bool = False) -> Iterator[None]:
        """Mesh, pull, resting shapes and what is known of the errors of mesh and step are at the end what they were, however it ends.

        Those that are to `stay` are so only where no simulation found its way.
        """
        kept = {name: (one.observed, one.defect_m, one.mesh_off_m, one.rest_m) for name, one in self.stages.items()}
        settings = self.finer, self.follow_hz
        try:
            yield
        except NotConverged:
            stay = False
            raise
        finally:
            if not stay:
                self.finer, self.follow_hz = settings
                for name, one in self.stages.items():
                    one.observed, one.defect_m, one.mesh_off_m, one.rest_m = kept[name]

    def mesh_off(self, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """What the mesh is taken to be off by in residuals (K,), by `refine`'s last look; zero before any."""
        found = {}
        for name in names:
            one, off_m = self.stages[name].observed, self.stages[name].mesh_off_m
            found[name] = np.zeros(len(one.measured_m)) if off_m is None else one.white(off_m)
        return found

    def stretches(self, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Which stretch of its recording each residual (K,) belongs to, see `Observed`."""
        return {name: self.observed(name).stretch for name in names}

    def foretell(self, world: World, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Markers (N, M, 3) from rest and drives alone, nothing pulled: what `sim1 predict` would say.

        Raises:
            NotConverged: a recording that no simulation follows.
        """
        told = self.foretold(world, names)
        for one in told.values():
            if isinstance(one, NotConverged):
                raise one
        return told

    def foretold(self, world: World, names: tuple[str, ...]) -> dict[str, np.ndarray | NotConverged]:
        """The same of every recording by itself: markers (N, M, 3), or why no simulation follows it."""
        tasks = [replace(self._task(name, (world,), self.finer, FINE_STEP_S), follow_hz=0.0) for name in names]
        runs = self.attempted(tasks)
        return {
            name: run if isinstance(run, NotConverged) else run.markers_m[0]
            for name, run in zip(names, runs, strict=True)
        }

    def soften(self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...]) -> Looked:
        """Trust a number less the more it hangs on the baseline's coefficients: where a sheet snaps, no simulator foretells it.

        A simulator that is wrong by `WOBBLE_Z` in each of them is wrong by so much there; added to what the mesh gets wrong.
        Returns what `slopes` would, now.
        """
        count = len(unknowns.nominal)
        runs, steps = self._twins(unknowns, z, names)
        for name, run in runs.items():
            stage = self.stages[name]
            lead = stage.observed.reduce(run[1 : count + 1] - run[0]) / steps[:count, None]
            wobble = WOBBLE_Z * np.linalg.norm(lead, axis=0)
            stage.observed = replace(stage.observed, mesh_m=np.hypot(stage.observed.mesh_m, wobble))
        return self._looked(runs, steps)

    def slopes(self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...], first: int = 0) -> Looked:
        """Residuals (K,) and their derivatives (K, P - first) over z[first:]."""
        return self._looked(*self._twins(unknowns, z, names, first))

    def residuals(self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """Residuals (K,) alone: a fraction of what slopes cost."""
        return self.slopes(unknowns, z, names, first=len(z))[0]

    def _twins(
        self, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...], first: int = 0
    ) -> tuple[dict[str, np.ndarray], np.ndarray]:
        low, high = unknowns.bounds()
        worlds, steps = [unknowns.world(z)], []
        for k in range(first, len(z)):
            away = unknowns.all[k].twin_z
            step = away if z[k] + away <= high[k] and (z[k] <= 0 or z[k] - away < low[k]) else -away
            moved = z.copy()
            moved[k] += step
            worlds.append(unknowns.world(moved))
            steps.append(step)
        return self._markers(worlds, names), np.array(steps)

    def answers(self, worlds: list[World], steps: np.ndarray, names: tuple[str, ...]) -> dict[str, np.ndarray]:
        """How residuals (K, W - 1) change, per unit, from the first world towards each of the others."""
        return self._looked(self._markers(worlds, names), steps)[1]

    @contextmanager
    def roughly(self) -> Iterator[None]:
        """On the other mesh, by what is known of errors on the working one: directions, not places."""
        with self.aside():
            self.finer = self.other_mesh
            yield

    def _looked(self, runs: dict[str, np.ndarray], steps: np.ndarray) -> Looked:
        residuals, slopes = {}, {}
        for name, run in runs.items():
            one = self.stages[name].observed
            residuals[name] = one.white(one.reduce(run[0]) - one.measured_m)
            slopes[name] = one.white((one.reduce(run[1:] - run[0]) / steps[:, None]).T)
        return residuals, slopes

    def _markers(self, worlds: list[World], names: tuple[str, ...]) -> dict[str, np.ndarray]:
        runs = self.run([self._task(name, tuple(worlds), self.finer, STEP_S) for name in names])
        return {name: run.markers_m + self.stages[name].defect_m for name, run in zip(names, runs, strict=True)}

    def task(self, name: str, world: World) -> Task:
        """A simulation of one world as searches ask for it."""
        return self._task(name, (world,), self.finer, STEP_S)

    def _task(self, name: str, worlds: tuple[World, ...], finer: int, step_s: float) -> Task:
        return Task(recording=name, worlds=worlds, finer=finer, step_s=step_s, follow_hz=self.follow_hz)

    def run(self, tasks: list[Task]) -> list[Done]:
        """Answers in the order of the tasks; their seconds count as simulating.

        Raises:
            NotConverged: a simulation found no rest or no next state.
        """
        runs = self.attempted(tasks)
        for run in runs:
            if isinstance(run, NotConverged):
                raise run
        return runs

    def attempted(self, tasks: list[Task]) -> list[Done | NotConverged]:
        """Answers as `run` gives them, and of each simulation that found no way why."""
        if not tasks:
            return []
        began = time.monotonic()
        runs = self.workers(tasks)
        taken_s = time.monotonic() - began
        self.simulating_s += taken_s
        working, pace_s = all(task.finer == self.finest for task in tasks), taken_s / sum(map(self._steps, tasks))
        self._pace_s[working] = min(pace_s, self._pace_s.get(working, pace_s))
        self.patience.reserve_s = self._pace_s.get(True, self._pace_s[working]) * self._closing_steps()
        for task, run in zip(tasks, runs, strict=True):
            if task.follow_hz and task.finer == self.finer and isinstance(run, Done):
                self.stages[task.recording].rest_m = run.rest_m
        return runs

    def _steps(self, task: Task) -> float:
        return float(np.ptp(self.stages[task.recording].scene.time_s)) / task.step_s

    def _closing_steps(self) -> float:
        """Steps that are simulated when the search is over: both models from rest, what is held out as fits do it, the baseline on the markers."""
        spans_s = [float(np.ptp(stage.scene.time_s)) for stage in self.stages.values()]
        other = 4.0 if self.other_mesh > self.finer else 1.0  # times the steps of the working mesh, by the vertices
        finer = FINER if self.finest else 0.0
        measured = 1.0 + other + 2.0 + finer  # on both meshes, by half steps, and on one that is finer still
        return sum(spans_s) * (2 / FINE_STEP_S + 1 / STEP_S) + max(spans_s) * (measured + ASKED) / STEP_S


def mesh_for(bundle: Bundle) -> int:
    """How often the bundle's mesh is refined before anything is simulated: markers that creep are off by more than a mesh is."""
    return int(len(bundle.mesh.vertices_m) < ENOUGH_VERTICES and not creep_m(bundle))
