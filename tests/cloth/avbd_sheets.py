"""Builders of small cloths for the solver's tests, and the loops that run them.

`SIM1_TEST_DEVICE=cuda:0 pytest tests/cloth` runs them on a GPU.
"""

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

wp.config.log_level = wp.LOG_ERROR

import newton  # noqa: E402

from sim1.cloth.avbd import AVBDConfig, SolverAVBD  # noqa: E402
from sim1.cloth.effects import Effect  # noqa: E402
from sim1.cloth.garment import checked_mesh, grid_towel  # noqa: E402
from sim1.cloth.model import hinge_stiffness  # noqa: E402

DEVICE = os.environ.get("SIM1_TEST_DEVICE", "cpu")
G = 9.81
RADIUS = 0.002
UNLIMITED = {"max_strain": float("inf")}


def square_grid(columns: int, rows: int, edge_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Points and faces of squares cut along alternating diagonals, in the plane z = 0 from the origin on."""
    points = edge_m * np.array([[i, j, 0.0] for j in range(rows) for i in range(columns)])
    faces = []
    for j in range(rows - 1):
        for i in range(columns - 1):
            a = j * columns + i
            b, c, d = a + 1, a + columns, a + columns + 1
            faces += [[a, b, c], [b, d, c]] if (i + j) % 2 else [[a, b, d], [a, d, c]]
    return points, np.array(faces)


def triangle_grid(width_m: float, length_m: float, edge_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Points and faces of nearly equilateral triangles; rows lie along x, from y = 0 on."""
    towel = grid_towel(width_m, length_m, edge_m)
    return towel.rest_m + np.array([0.0, 0.5 * length_m, 0.0]), towel.faces


def add_cloth(builder: Any, points: np.ndarray, faces: np.ndarray, **material: float) -> None:
    soft = {"density": 0.2, "tri_ke": 100.0, "tri_ka": 100.0, "tri_kd": 0.0, "edge_ke": 1e-4, "edge_kd": 0.0}
    builder.add_cloth_mesh(
        vertices=[wp.vec3(*map(float, point)) for point in points],
        indices=np.asarray(faces).reshape(-1).tolist(),
        pos=wp.vec3(0.0),
        rot=wp.quat_identity(),
        vel=wp.vec3(0.0),
        scale=1.0,
        **{**soft, "particle_radius": RADIUS, **material},
    )


def cloth(
    points: np.ndarray,
    faces: np.ndarray,
    *,
    gravity: tuple[float, float, float] = (0.0, 0.0, -G),
    ground: dict[str, float] | None = None,
    **material: float,
) -> Any:
    """A newton model of one cloth at rest in `points`, over the plane z = 0 if `ground` gives its material."""
    builder = newton.ModelBuilder(gravity=gravity)
    if ground is not None:
        builder.add_ground_plane(cfg=newton.ModelBuilder.ShapeConfig(margin=0.0, **ground))
    add_cloth(builder, points, faces, **material)
    builder.color()
    return builder.finalize(device=DEVICE)


def hold(model: Any, held: np.ndarray) -> None:
    flags = model.particle_flags.numpy()
    flags[held] &= ~int(newton.ParticleFlags.ACTIVE)
    model.particle_flags.assign(flags)


def make_plate(model: Any, points: np.ndarray, faces: np.ndarray, rigidity_n_m: float, damping_s: float = 0.0) -> None:
    """Give the hinges the stiffness of a plate of this rigidity D."""
    mesh = checked_mesh(points, faces, points)
    stiffness = hinge_stiffness(mesh, model.edge_indices.numpy(), rigidity_n_m)
    model.edge_bending_properties.assign(np.stack([stiffness, damping_s * stiffness], axis=1).astype(np.float32))


def edge_stretch(model: Any, x: np.ndarray) -> np.ndarray:
    """Length of each edge over its length at rest."""
    start, end = model.edge_indices.numpy().reshape(-1, 4)[:, 2:].T
    return np.linalg.norm(x[start] - x[end], axis=1) / model.edge_rest_length.numpy()


class Run:
    """A cloth on its way: `step` advances it; the model must be complete before this is made."""

    def __init__(
        self,
        model: Any,
        dt: float,
        touching: bool = False,
        effects: tuple[Effect, ...] = (),
        table: int | None = None,
        moves_bodies: bool = False,
        **config: Any,
    ) -> None:
        self.model, self.dt = model, dt
        numbers = AVBDConfig(**{**UNLIMITED, **config})
        self.solver = SolverAVBD(model, numbers, effects=effects, table=table, moves_bodies=moves_bodies)
        self.now, self.then = model.state(), model.state()
        self.pipeline = newton.CollisionPipeline(model, soft_contact_gap=0.005) if touching else None
        self.contacts = self.pipeline.contacts() if touching else None

    @property
    def x(self) -> np.ndarray:
        return self.now.particle_q.numpy().astype(float)

    @property
    def v(self) -> np.ndarray:
        return self.now.particle_qd.numpy().astype(float)

    def put(self, x: np.ndarray | None = None, v: np.ndarray | None = None) -> "Run":
        for values, field in ((x, self.now.particle_q), (v, self.now.particle_qd)):
            if values is not None:
                wide = np.broadcast_to(np.asarray(values, np.float32), (self.model.particle_count, 3))
                field.assign(np.ascontiguousarray(wide))
        return self

    def step(self, count: int = 1, after_each: Callable[["Run"], None] | None = None) -> "Run":
        for _ in range(count):
            if self.pipeline is not None:
                self.pipeline.collide(self.now, self.contacts)
            self.solver.step(self.now, self.then, None, self.contacts, self.dt)
            self.now, self.then = self.then, self.now
            if after_each is not None:
                after_each(self)
        return self

    def trace(self, count: int, value: Callable[["Run"], Any]) -> np.ndarray:
        """`value` at the start and after each step."""
        values = [value(self)]
        self.step(count, lambda run: values.append(value(run)))
        return np.array(values)


def equilibrium(model: Any, iterations: int, steps: int = 3, x: np.ndarray | None = None, **config: Any) -> np.ndarray:
    """Positions at rest: steps so long that inertia is nothing, each begun at rest."""
    run = Run(model, 10.0, iterations=iterations, warm_acceleration_g=0.0, **config).put(x=x)
    for _ in range(steps):
        run.put(v=np.zeros(3)).step()
    return run.x
