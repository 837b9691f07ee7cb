"""A pull in newton: steps recorded as a graph and replayed, so that launching from Python costs no contestant anything."""

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp


@wp.kernel
def lead(
    held: wp.array(dtype=wp.int32),
    path: wp.array(dtype=float),
    step: wp.array(dtype=wp.int32),
    start: wp.array(dtype=wp.vec3),
    position: wp.array(dtype=wp.vec3),
):
    """Put the held vertices where the path has them after this step."""
    way = path[wp.min(step[0], path.shape[0] - 1)]
    step[0] += 1
    for i in range(held.shape[0]):
        position[held[i]] = start[i] + wp.vec3(way, 0.0, 0.0)


def now_s(device: Any) -> float:
    """Seconds of this process's processor where the device is one; else of the clock, once the device has done all it was told."""
    if device.is_cpu:
        return time.process_time()
    wp.synchronize_device(device)
    return time.perf_counter()


class NewtonRun:
    """Two steps at a time; `seconds` are of the processor where the device is one, else of the clock."""

    def __init__(
        self,
        model: Any,
        solver: Any,
        dt_s: float,
        held: Sequence[int],
        *,
        graph: bool = True,
        contacts: Any = None,
        path_s: float = 2.0,
    ) -> None:
        from benchmarks.solver.contestants import corner_way_m

        self.model, self.solver, self.dt_s, self.contacts = model, solver, dt_s, contacts
        self.seconds, self.steps = 0.0, 0
        self.states = [model.state(), model.state()]
        self._control = model.control()
        count = round(path_s / dt_s)
        with wp.ScopedDevice(model.device):
            self._held = wp.array(np.array(held, dtype=np.int32), dtype=wp.int32)
            self._start = wp.array(model.particle_q.numpy()[list(held)].reshape(-1, 3), dtype=wp.vec3)
            way = [corner_way_m((step + 1) * dt_s) for step in range(count)]
            self._path = wp.array(np.array(way, dtype=np.float32), dtype=float)
            self._step = wp.zeros(1, dtype=wp.int32)
        self._graph = self._record() if graph else None

    def place(self, positions: np.ndarray, velocity: np.ndarray | None = None) -> None:
        """Start from these positions (v, 3) [m], at rest or with this velocity (3,) [m/s]."""
        for state in self.states:
            state.particle_q.assign(np.ascontiguousarray(positions, dtype=np.float32))
            state.particle_qd.zero_()
        if velocity is not None:
            speeds = np.broadcast_to(velocity, (self.model.particle_count, 3)).astype(np.float32)
            self.states[0].particle_qd.assign(np.ascontiguousarray(speeds))
        self._step.zero_()

    def advance(self, pairs: int = 1) -> None:
        """Two steps, `pairs` times."""
        began = now_s(self.model.device)
        for _ in range(pairs):
            if self._graph is None:
                self._two_steps()
            else:
                wp.capture_launch(self._graph)
        self.seconds += now_s(self.model.device) - began
        self.steps += 2 * pairs

    def points(self) -> np.ndarray:
        """Positions (v, 3) [m]."""
        return self.states[0].particle_q.numpy().astype(float)

    def _record(self) -> Any:
        self._two_steps()  # loads every kernel, which a recording cannot do
        self.place(self.model.particle_q.numpy())
        with wp.ScopedCapture(device=self.model.device) as capture:
            self._two_steps()
        return capture.graph

    def _two_steps(self) -> None:
        now, then = self.states
        for _ in range(2):
            if len(self._held):
                inputs = [self._held, self._path, self._step, self._start, now.particle_q]
                wp.launch(lead, dim=1, inputs=inputs, device=self.model.device)
            self.solver.step(now, then, self._control, self.contacts, self.dt_s)
            now, then = then, now
