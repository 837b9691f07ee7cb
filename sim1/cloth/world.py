"""Cloth, table and two parallel grippers as free-flying kinematic bodies, in newton.

The layer below the robot cell: it knows tool poses and finger gaps, not arms.
"""

import json
from collections import deque
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from sim1.cloth.config import BODIES_PER_ARM, FRAME_S, CellConfig
from sim1.cloth.garment import GarmentMesh
from sim1.cloth.model import build_model, contacts_of, solver_of
from sim1.cloth.physics import ClothPhysics

KEPT_FRAMES = 5  # states kept for the day the simulation breaks


class SimulationBroke(RuntimeError):
    """The cloth's state is not a number, or flew away, or layers were nearer to each other than the solver has room for."""

    def __init__(self, frame: int, vertex: int, what: str) -> None:
        super().__init__(f"simulation broke at frame {frame}: {what}")
        self.frame, self.vertex = frame, vertex


class ClothWorld:
    """Cloth over a table at z = 0 with one gripper per arm; `step` advances 1/30 s. Same inputs, same bytes on CPU."""

    def __init__(
        self,
        garment: GarmentMesh,
        physics: ClothPhysics,
        config: CellConfig,
        *,
        table_size_m: tuple[float, float] = (0.8, 1.2),
        device: str = "cpu",
        broken_to: Path | None = None,
    ) -> None:
        """A world at rest; `broken_to` (.npz) takes the last states and all parameters when the simulation breaks."""
        import warp as wp

        wp.config.log_level = wp.LOG_ERROR
        self._wp, self.config, self.garment, self.device = wp, config, garment, device
        self._physics, self._broken_to = physics, broken_to
        self._kept: deque[dict[str, np.ndarray]] = deque(maxlen=KEPT_FRAMES)
        self._dt = FRAME_S / config.substeps
        with wp.ScopedDevice(device):
            self._model = build_model(garment, physics, config, table_size_m)
            self._states = [self._model.state(), self._model.state()]
            self._control = self._model.control()
            self._pipeline, self._contacts = contacts_of(self._model, physics, config)
            self._solver = solver_of(self._model, garment, physics, config)
            count = config.substeps + 1
            self._body_path = [wp.zeros(2 * BODIES_PER_ARM, dtype=wp.transform) for _ in range(count)]
        self.frame = 0
        self._graph = self._record(_parked_tools())
        self.reset(garment.rest_m, _parked_tools(), np.zeros(2))

    def reset(self, garment_m: np.ndarray, tools: np.ndarray, gaps_m: np.ndarray) -> None:
        """Put the cloth (v, 3) at rest there, tools (2, 4, 4) and finger gaps (2,) likewise."""
        positions = np.ascontiguousarray(garment_m, dtype=np.float32)
        if positions.shape != self.garment.vertices_m.shape or not np.isfinite(positions).all():
            raise ValueError(
                f"garment positions {positions.shape} do not fit {self.garment.vertices_m.shape}, or not finite"
            )
        for state in self._states:
            state.particle_q.assign(positions)
            state.particle_qd.zero_()
            state.particle_f.zero_()
        self._solver.reset(self._states[0])
        self.tools, self.gaps_m = np.array(tools, float), np.array(gaps_m, float)
        self.frame = 0
        self._kept.clear()

    def push(self, velocity_m_s: np.ndarray) -> None:
        """Give the whole cloth this velocity (3,), after a reset; for experiments on friction and damping."""
        speeds = np.broadcast_to(np.asarray(velocity_m_s, np.float32), self.garment.vertices_m.shape)
        self._states[0].particle_qd.assign(np.ascontiguousarray(speeds))

    def fix(self, vertices: np.ndarray) -> None:
        """Hold vertices (v,) bool where they are, for experiments on hanging cloth. The cell never does this."""
        flags = self._model.particle_flags.numpy()
        self._model.particle_flags.assign(np.where(vertices, flags & ~1, flags | 1).astype(flags.dtype))

    @property
    def garment_m(self) -> np.ndarray:
        """Cloth vertices (v, 3) float32, a copy."""
        return self._states[0].particle_q.numpy().copy()

    @property
    def garment_m_s(self) -> np.ndarray:
        """Cloth velocities (v, 3) float32, a copy."""
        return self._states[0].particle_qd.numpy().copy()

    def step(self, tools: np.ndarray, gaps_m: np.ndarray) -> None:
        """Advance 1/30 s while tools (2, 4, 4) and gaps (2,) move evenly to the given ones.

        Raises:
            SimulationBroke: a position is not finite or out of all bounds.
        """
        path = body_path(self.tools, tools, self.gaps_m, gaps_m, self.config)
        for target, poses in zip(self._body_path, path):
            target.assign(poses)
        if self.config.self_contact:
            self._solver.rebuild_bvh()
        self._wp.capture_launch(self._graph)
        self.tools, self.gaps_m = np.array(tools, float), np.array(gaps_m, float)
        self.frame += 1
        self._watch()

    def _watch(self) -> None:
        """Keep the state, or raise SimulationBroke with the vertex and the term that broke first."""
        positions = self._states[0].particle_q.numpy()
        self._kept.append(
            {"garment_m": positions.copy(), "garment_m_s": self.garment_m_s, "tools": self.tools, "gaps_m": self.gaps_m}
        )
        bad = ~(np.abs(positions) < self.config.far_limit_m).all(axis=1)
        vertex = int(np.argmax(bad))
        what = f"vertex {vertex} is at {positions[vertex].tolist()}" if bad.any() else ""
        try:
            broken = self._solver.broken()
        except RuntimeError as error:
            what = str(error)
        else:
            if broken is not None:
                vertex = broken.vertex
                what = f"the step of vertex {vertex} is not a number, first in the term {broken.term!r}"
        if what:
            raise SimulationBroke(self.frame, vertex, what + self._written())

    def _written(self) -> str:
        if self._broken_to is None:
            return ""
        kept = {name: np.stack([state[name] for state in self._kept]) for name in self._kept[0]}
        parameters = json.dumps({"cell": asdict(self.config), "physics": asdict(self._physics)}, sort_keys=True)
        np.savez(self._broken_to, **kept, faces=self.garment.faces, rest_m=self.garment.rest_m, parameters=parameters)
        return f"; the last {len(self._kept)} frames and all parameters are in {self._broken_to.name}"

    def _record(self, tools: np.ndarray) -> Any:
        """Record the launches of one frame: replaying them takes 0.6 of the time of launching from Python, same bytes."""
        for target, poses in zip(self._body_path, body_path(tools, tools, np.zeros(2), np.zeros(2), self.config)):
            target.assign(poses)
        self._advance()  # loads every kernel, which a recording cannot do
        with self._wp.ScopedCapture(device=self.device) as capture:
            self._advance()
        return capture.graph

    def _advance(self) -> None:
        now, then = self._states
        for substep in range(self.config.substeps):
            self._wp.copy(now.body_q, self._body_path[substep])
            self._wp.copy(then.body_q, self._body_path[substep + 1])
            self._pipeline.collide(now, self._contacts)
            self._solver.step(now, then, self._control, self._contacts, self._dt)
            now, then = then, now


def body_path(
    start: np.ndarray, end: np.ndarray, gap_start: np.ndarray, gap_end: np.ndarray, config: CellConfig
) -> np.ndarray:
    """Poses of palms and fingers at the ends of all substeps: (substeps + 1, 6, 7), position and quaternion xyzw."""
    from scipy.spatial.transform import Rotation, Slerp

    share = np.linspace(0.0, 1.0, config.substeps + 1)
    poses = np.empty((len(share), 2 * BODIES_PER_ARM, 7), dtype=np.float32)
    for arm in range(2):
        turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([start[arm, :3, :3], end[arm, :3, :3]])))(share)
        origin = start[arm, :3, 3] + share[:, None] * (end[arm, :3, 3] - start[arm, :3, 3])
        gap = np.maximum(gap_start[arm] + share * (gap_end[arm] - gap_start[arm]), config.closed_gap_m)
        side = 0.5 * (gap + config.finger_thickness_m)
        for body, sign in enumerate((0.0, 1.0, -1.0)):
            offset = np.zeros((len(share), 3))
            offset[:, 1] = sign * side
            poses[:, arm * BODIES_PER_ARM + body, :3] = origin + turn.apply(offset)
            poses[:, arm * BODIES_PER_ARM + body, 3:] = turn.as_quat()
    return poses


def _parked_tools() -> np.ndarray:
    """Tools out of the way, fingers down, a metre above the table."""
    down = np.array([[0.0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 1.0], [0, 0, 0, 1]])
    tools = np.stack([down, down])
    tools[:, 1, 3] = (0.4, -0.4)
    return tools
