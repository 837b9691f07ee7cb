"""Cloth, table and two parallel grippers as free-flying kinematic bodies, in newton.

The layer below the robot cell: it knows tool poses and finger gaps, not arms.
"""

from typing import Any

import numpy as np
from pydantic import Field

from sim1.cloth.garment import GarmentMesh, face_areas, unique_edges
from sim1.cloth.physics import ClothPhysics, membrane
from sim1.cloth.solver import SelfContact, SolverName, make_solver
from sim1.stage import stage_config

FRAME_S = 1.0 / 30.0
GRAVITY_M_S2 = 9.81
BODIES_PER_ARM = 3  # palm and two fingers, in this order


class SimulationBroke(RuntimeError):
    """The cloth's state is not a number, or flew away."""

    def __init__(self, frame: int, vertex: int, position: np.ndarray) -> None:
        super().__init__(f"simulation broke at frame {frame}: vertex {vertex} is at {np.asarray(position).tolist()}")
        self.frame, self.vertex = frame, vertex


@stage_config
class CellConfig:
    """Numerics and contact of the simulated cell."""

    solver: SolverName = "vbd"
    substeps: int = Field(8, ge=2, multiple_of=2)  # per 1/30 s; even, so that the two states end where they began
    iterations: int = Field(5, ge=1)  # per substep
    contact_radius_m: float = Field(0.002, gt=0)  # distance kept between the cloth's middle surface and solids
    self_margin_m: float = Field(0.003, gt=0)  # distance kept between two layers
    self_search_m: float = Field(0.006, gt=0)  # detection looks this far ahead of the margin; see `top_speed_m_s`
    self_contact: bool = True  # layers collide
    finger_surface_contact: bool = True  # fingers touch edges and faces of the cloth, not its vertices alone
    table_stiffness_n_m: float = 300.0  # penalty per vertex: sags 7 um under 0.2 g; stiffer makes friction too strong
    robot_stiffness_n_m: float = 1.5e3  # rubber pads: yield 1 mm at 1.5 N per vertex
    self_stiffness_n_m: float = 2.0e2  # gentle, layers are light
    contact_damping_n_s_m: float = 0.2  # per vertex, takes the bounce out of landings
    friction_speed_m_s: float = 2.0e-3  # sticking creeps below this speed (regularised Coulomb)
    closed_gap_m: float = Field(0.002, gt=0)  # left between closed pads: their rubber; holds the cloth by its yield
    finger_length_m: float = 0.060  # along the tool's x, ends at the tool's origin; as in the URDF
    finger_width_m: float = 0.022  # along the tool's z; as in the URDF
    finger_thickness_m: float = 0.010  # along the tool's y; as in the URDF
    finger_rounding_m: float = 0.0015  # edges of a pad are round
    far_limit_m: float = 50.0  # a vertex further than this from the origin means that the simulation broke


def top_speed_m_s(config: CellConfig) -> float:
    """Speed that no vertex can exceed: with self-contact the solver cuts a substep's motion to 0.85 / 2 of the search range."""
    reach = config.self_margin_m + config.self_search_m
    return 0.425 * reach * config.substeps / FRAME_S if config.self_contact else float("inf")


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
    ) -> None:
        import warp as wp

        wp.config.log_level = wp.LOG_ERROR
        self._wp, self.config, self.garment, self.device = wp, config, garment, device
        self._dt = FRAME_S / config.substeps
        with wp.ScopedDevice(device):
            self._model = _build_model(garment, physics, config, table_size_m)
            self._states = [self._model.state(), self._model.state()]
            self._control = self._model.control()
            self._pipeline, self._contacts = _contacts_of(self._model, config)
            self._solver = make_solver(
                self._model,
                config.solver,
                iterations=config.iterations,
                friction_speed_m_s=config.friction_speed_m_s,
                self_contact=_self_contact(garment, config) if config.self_contact else None,
            )
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
        self.tools, self.gaps_m = np.array(tools, float), np.array(gaps_m, float)
        self.frame = 0

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
            self._solver.rebuild_bvh(self._states[0])
        self._wp.capture_launch(self._graph)
        self.tools, self.gaps_m = np.array(tools, float), np.array(gaps_m, float)
        self.frame += 1
        positions = self._states[0].particle_q.numpy()
        bad = ~(np.abs(positions) < self.config.far_limit_m).all(axis=1)
        if bad.any():
            vertex = int(np.flatnonzero(bad)[0])
            raise SimulationBroke(self.frame, vertex, positions[vertex])

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


def _build_model(
    garment: GarmentMesh, physics: ClothPhysics, config: CellConfig, table_size_m: tuple[float, float]
) -> Any:
    import newton
    import warp as wp

    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY_M_S2))
    own = physics.friction.self.value
    # The solver pairs coefficients by their geometric mean with the cloth's own; undo that so that each acts as given.
    pair = {name: getattr(physics.friction, name).value ** 2 / max(own, 1e-6) for name in ("table", "robot")}
    solid = {"kd": 2.0 * config.contact_damping_n_s_m, "margin": config.finger_rounding_m, "density": 0.0}
    table = newton.ModelBuilder.ShapeConfig(
        ke=2.0 * config.table_stiffness_n_m - config.self_stiffness_n_m, mu=pair["table"], **{**solid, "margin": 0.0}
    )
    pad = newton.ModelBuilder.ShapeConfig(
        ke=2.0 * config.robot_stiffness_n_m - config.self_stiffness_n_m, mu=pair["robot"], **solid
    )
    half = 0.5 * np.asarray(table_size_m)
    deep = 0.1  # thicker than any table top: a vertex pressed in is always pushed out upwards
    builder.add_shape_box(
        -1, xform=wp.transform((0.0, 0.0, -deep), wp.quat_identity()), hx=half[0], hy=half[1], hz=deep, cfg=table
    )
    inset = config.finger_rounding_m
    for arm in ("left", "right"):
        for part in ("palm", "finger_a", "finger_b"):
            body = builder.add_body(label=f"{arm}_{part}", is_kinematic=True, mass=1.0, inertia=wp.mat33(np.eye(3)))
            if part == "palm":
                middle, half = -config.finger_length_m - 0.02, (0.02, 0.055, 0.024)  # as in the URDF
            else:
                middle = -0.5 * config.finger_length_m
                half = (0.5 * config.finger_length_m, 0.5 * config.finger_thickness_m, 0.5 * config.finger_width_m)
            builder.add_shape_box(
                body,
                xform=wp.transform((middle, 0.0, 0.0), wp.quat_identity()),
                hx=half[0] - inset,
                hy=half[1] - inset,
                hz=half[2] - inset,
                cfg=pad,
                label=f"{arm}_{part}",
            )
    lame = membrane(physics)
    builder.add_cloth_mesh(
        vertices=[wp.vec3(*map(float, point)) for point in garment.rest_m],
        indices=garment.faces.reshape(-1).tolist(),
        pos=wp.vec3(0.0),
        rot=wp.quat_identity(),
        vel=wp.vec3(0.0),
        scale=1.0,
        density=physics.area_density_kg_m2.value,
        tri_ke=lame.mu_n_m,
        tri_ka=lame.lambda_n_m,
        tri_kd=lame.viscosity_n_s_m,
        edge_ke=1.0,
        edge_kd=0.0,
        particle_radius=config.contact_radius_m,
    )
    builder.color()
    model = builder.finalize()
    model.soft_contact_ke = config.self_stiffness_n_m
    model.soft_contact_kd = 0.0
    model.soft_contact_mu = max(own, 1e-6)
    stiffness = hinge_stiffness(garment, model.edge_indices.numpy(), physics.bending_n_m.value)
    model.edge_bending_properties.assign(
        np.stack([stiffness, physics.damping_s.value * stiffness], axis=1).astype(np.float32)
    )
    return model


def hinge_stiffness(garment: GarmentMesh, edges: np.ndarray, bending_n_m: float) -> np.ndarray:
    """Stiffness per edge length [N] of the hinges (opposite, opposite, start, end) that make a plate of rigidity D.

    The solver's hinge energy is k L theta^2 / 2. A sheet of equilateral triangles of hinge stiffness k L has D = sqrt(3)/2 k L
    (Seung and Nelson 1988); written with the areas of the two faces that is k = D L / (A1 + A2), used for all meshes.
    """
    points = garment.rest_m
    first, second, start, end = (np.where(edges[:, i] < 0, edges[:, 2], edges[:, i]) for i in range(4))
    along = points[end] - points[start]
    area = 0.5 * np.linalg.norm(np.cross(along, points[first] - points[start]), axis=1)
    area += 0.5 * np.linalg.norm(np.cross(along, points[second] - points[start]), axis=1)
    return bending_n_m * np.linalg.norm(along, axis=1) / np.maximum(area, 1e-12)


def _contacts_of(model: Any, config: CellConfig) -> tuple[Any, Any]:
    """Detection of the cloth against solids: vertices against all; edges and faces against the fingers alone.

    A finger is narrower than the cloth's edges are long: with vertices alone it would slip through a triangle and stay
    hooked in it. The table is flat, vertices are enough there.
    """
    import newton
    import warp as wp

    pipeline = newton.CollisionPipeline(
        model,
        soft_contact_gap=0.005,
        include_static_kinematic_pairs=False,
        broad_phase="explicit",
        enable_rigid_soft_full_surface_contact=config.finger_surface_contact,
    )
    contacts = pipeline.contacts()
    if config.finger_surface_contact:
        fingers = [i for i, label in enumerate(model.shape_label) if "finger" in label]
        for name in ("soft_edge_rigid_pairs", "soft_face_rigid_pairs"):
            pairs = getattr(pipeline, name).numpy()
            kept = pairs[np.isin(pairs[:, 1], fingers)]
            setattr(pipeline, name, wp.array(kept, dtype=wp.vec2i, device=model.device))
    return pipeline, contacts


def _self_contact(garment: GarmentMesh, config: CellConfig) -> SelfContact:
    edges = unique_edges(garment.faces)
    shortest = float(np.linalg.norm(garment.rest_m[edges[:, 0]] - garment.rest_m[edges[:, 1]], axis=1).min())
    return SelfContact(
        margin_m=config.self_margin_m,
        search_gap_m=config.self_search_m,
        rest_exclusion_m=min(2.0 * config.self_margin_m, 0.9 * shortest),
    )


def total_mass_kg(garment: GarmentMesh, physics: ClothPhysics) -> float:
    """Mass [kg] of the garment: rest area times area density."""
    return float(face_areas(garment.rest_m, garment.faces).sum() * physics.area_density_kg_m2.value)
