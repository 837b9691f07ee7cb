"""Simulations of a bundle's recordings in processes of their own, one per core.

A recording always goes to the same process, which has its scenes ready and starts from how the recording moved last time.
"""

import multiprocessing
import os
import signal
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace

import numpy as np

from sim1.child_process import behave_as_child
from sim1.cloth.precise.lacking import lacking_force
from sim1.cloth.precise.marker_states import MarkerStates, marker_states
from sim1.cloth.precise.motions import Motions, on_finer
from sim1.cloth.precise.pull import Goals, Pull
from sim1.cloth.precise.scene import Scene, prepare
from sim1.cloth.precise.simulate import NotConverged, simulate
from sim1.cloth.precise.world import World
from sim1.recording.bundle import Bundle, Recording
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Task:
    """One simulation that a worker is asked for."""

    recording: str
    worlds: tuple[World, ...]
    finer: int  # how often every face of the given mesh is cut into four
    step_s: float
    follow_hz: float = 0.0  # of the pull towards the markers; 0: none
    goals_m: np.ndarray | None = None  # (N, M, 3) markers to follow in place of the measured ones
    paths: bool = False  # whether to return what the markers and the sheet around them do at the steps
    lacks: World | None = None  # whose lack of force to return in place of the pull


@dataclass(frozen=True, kw_only=True)
class Done:
    """What a worker returns."""

    markers_m: np.ndarray  # (P, N, M, 3)
    rest_m: np.ndarray  # (V, 3) of the mesh that was asked for
    force_n: np.ndarray | None = None  # (T, M, 3)
    path_m: np.ndarray | None = None  # (T, M, 3)
    states: MarkerStates | None = None


_BUNDLE: list[Bundle] = []
_SCENES: dict[tuple[str, int, float], Scene] = {}
_GOALS: dict[str, Goals] = {}
_MOTIONS: dict[tuple[str, int, float, float], Motions] = {}


def _begin(bundle: Bundle) -> None:
    behave_as_child()
    # One to the whole group asks its parent to come to an end (`patience.py`), for which it is still needed.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    _BUNDLE[:] = [bundle]


def _work(task: Task) -> Done:
    bundle = _BUNDLE[0]
    recording = next(r for r in bundle.recordings if r.name == task.recording)
    key = task.recording, task.finer, task.step_s
    scene = _scene(task)
    pull = Pull(hz=task.follow_hz, goals=_goals(recording, task.goals_m)) if task.follow_hz else None
    worlds, where = _distinct(task.worlds, scene)
    motions = _MOTIONS.setdefault((*key, task.follow_hz), Motions())
    shapes = motions.guess(worlds[0])
    near = None if shapes is None else shapes[0]
    if shapes is None:
        shapes = _of_another_kind(task, worlds[0])  # rest is sought from the markers all the same: it may lie elsewhere
    try:
        run = simulate(scene, worlds, near=near, guess=shapes, pull=pull, leads=True)
    except NotConverged:  # perhaps from where the last motion was: once more from the markers
        if shapes is None:
            raise
        run = simulate(scene, worlds, pull=pull, leads=True)
    motions.keep(worlds, run.shapes_m, run.leads_m)
    if not task.paths:
        return Done(markers_m=run.markers_m[where], rest_m=run.rest_m)
    force = run.pull_n if task.lacks is None else lacking_force(scene, worlds[0], task.lacks, run.shapes_m)
    path = (run.shapes_m[:, scene.net.marker_node] * scene.net.marker_weight[..., None]).sum(2)
    states = marker_states(scene, run.shapes_m)
    return Done(markers_m=run.markers_m[where], rest_m=run.rest_m, force_n=force, path_m=path, states=states)


def _scene(task: Task) -> Scene:
    key = task.recording, task.finer, task.step_s
    if key not in _SCENES:
        recording = next(r for r in _BUNDLE[0].recordings if r.name == task.recording)
        _SCENES[key] = prepare(_BUNDLE[0], recording, task.step_s, finer=task.finer)
    return _SCENES[key]


def _of_another_kind(task: Task, world: World) -> np.ndarray | None:
    """Shapes (T, V, 3) of the same motion as it was followed otherwise, or on the mesh before the last cut; None: neither was simulated."""
    for finer in (task.finer, task.finer - 1):
        key = task.recording, finer, task.step_s
        for follow_hz in sorted(
            {kind[3] for kind in _MOTIONS if kind[:3] == key}, key=lambda hz: abs(hz - task.follow_hz)
        ):
            shapes = _MOTIONS[*key, follow_hz].guess(world)
            if shapes is not None:
                return shapes if finer == task.finer else on_finer(shapes, _SCENES[key], _scene(task))
    return None


def _goals(recording: Recording, given_m: np.ndarray | None) -> Goals:
    if given_m is not None:
        return Goals.of(recording.time_s, given_m)
    if recording.name not in _GOALS:
        _GOALS[recording.name] = Goals.of(recording.time_s, recording.markers_m)
    return _GOALS[recording.name]


def _distinct(worlds: tuple[World, ...], scene: Scene) -> tuple[list[World], list[int]]:
    """Worlds that differ in this recording, and which of them each one is: a grip that it does not use can do nothing here."""
    used = [grip.index for grip in scene.grips]
    seen: dict[World, int] = {}
    where = []
    for world in worlds:
        places = tuple(world.places[k] for k in used) if world.places else ()
        where.append(seen.setdefault(replace(world, places=places), len(where)))
    order = sorted(set(where))
    return [worlds[k] for k in order], [order.index(k) for k in where]


def _answer(future: Future[Done]) -> Done | NotConverged:
    try:
        return future.result()
    except NotConverged as error:
        return error
    except BrokenProcessPool as error:
        raise BadInput(
            "a process that simulates was ended from outside, as systems do where memory is short; nothing is wrong with the recordings: "
            "free some memory, and diagnose again"
        ) from error


class Workers:
    """Processes that answer tasks in their order."""

    def __init__(self, bundle: Bundle, processes: int | None = None):
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one thread each: the matrices are small
        self._pools = [
            ProcessPoolExecutor(
                1, mp_context=multiprocessing.get_context("spawn"), initializer=_begin, initargs=(bundle,)
            )
            for _ in range(min(processes or os.cpu_count() or 1, len(bundle.recordings)))
        ]
        self._seconds = {one.name: float(one.time_s[-1] - one.time_s[0]) for one in bundle.recordings}
        self._owner: dict[str, int] = {}

    def __call__(self, tasks: Sequence[Task]) -> list[Done | NotConverged]:
        """Answers in the order of the tasks; where a simulation found no rest or no next state, what it says of that.

        Raises:
            BadInput: a process was ended from outside.
        """
        self._own({task.recording for task in tasks} - set(self._owner))
        waiting = [self._pools[self._owner[task.recording]].submit(_work, task) for task in tasks]
        return [_answer(future) for future in waiting]

    def _own(self, recordings: set[str]) -> None:
        """Give each recording to the process with the fewest seconds to simulate, the longest first (Graham 1969)."""
        for name in sorted(recordings, key=lambda name: (-self._seconds[name], name)):
            load = [0.0] * len(self._pools)
            for owned, process in self._owner.items():
                load[process] += self._seconds[owned]
            self._owner[name] = load.index(min(load))

    def close(self) -> None:
        """End the processes."""
        for pool in self._pools:
            pool.shutdown(cancel_futures=True)
