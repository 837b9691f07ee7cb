"""`SolverAVBD`: cloth by augmented vertex block descent, as a newton solver."""

from typing import Any

import numpy as np
import warp as wp
from newton.solvers import SolverBase

from sim1.cloth.avbd import advance, layers, solids, sweep
from sim1.cloth.avbd.iterate import Iterate, StepNumbers
from sim1.cloth.avbd.parameters import AVBDConfig
from sim1.cloth.avbd.sheet import sheet_of
from sim1.cloth.avbd.touch import Guard, Touches


class SolverAVBD(SolverBase):
    """Steps the cloth of a newton model; bodies move from `state_in` to `state_out` as the caller has set them."""

    def __init__(self, model: Any, config: AVBDConfig | None = None) -> None:
        super().__init__(model)
        self.config = config or AVBDConfig()
        self.sheet = sheet_of(model, self.config.compression_share)
        self.fused = model.device.is_cpu if self.config.fused is None else self.config.fused
        self.step_count = 0
        with wp.ScopedDevice(model.device):
            self.now = _iterate(model, self.sheet, self.config)
            self._second_order = int(self.config.integrator == "bdf2")
            self._world = wp.clone(model.particle_world)
            self._solids = _touches(model.particle_count, 0)
            capacity = 0
            if self.config.self_contact is not None:
                capacity = self.config.self_contact.capacity_per_vertex * model.particle_count
            self._layers = _touches(model.particle_count, capacity)
            self._guard = _guard(model, self.config)
            self._due = wp.ones(1, dtype=wp.int32)
            self._rest = wp.clone(model.particle_q)
            self._wrench = wp.zeros(max(model.body_count, 1), dtype=wp.spatial_vector)
            if capacity:
                self._trees()

    def _trees(self) -> None:
        sheet, model = self.sheet, self.model
        for name, corners in (("triangle", sheet.triangle), ("edge", sheet.edge)):
            low = wp.zeros(len(corners), dtype=wp.vec3)
            high = wp.zeros(len(corners), dtype=wp.vec3)
            first = corners.numpy()[:, 0]
            groups = np.maximum(model.particle_world.numpy(), 0)[first].astype(np.int32)
            points = model.particle_q.numpy()[corners.numpy()]
            low.assign(points.min(axis=1))
            high.assign(points.max(axis=1))
            setattr(self, f"_{name}_low", low)
            setattr(self, f"_{name}_high", high)
            setattr(self, f"_{name}_tree", wp.Bvh(low, high, groups=wp.array(groups, dtype=wp.int32)))
        self._group = wp.array(np.maximum(model.particle_world.numpy(), 0), dtype=wp.int32)

    def step(self, state_in: Any, state_out: Any, control: Any, contacts: Any, dt: float) -> None:
        """Advance `state_in` to `state_out` by `dt` [s]."""
        model, sheet, now, config = self.model, self.sheet, self.now, self.config
        numbers = self._numbers(dt)
        count = model.particle_count
        with wp.ScopedDevice(model.device):
            wp.launch(
                advance.begin_step,
                dim=count,
                inputs=[
                    sheet,
                    now,
                    self._second_order,
                    dt,
                    state_in.particle_q,
                    state_in.particle_qd,
                    state_in.particle_f,
                    model.particle_inv_mass,
                    model.particle_flags,
                    model.gravity,
                    self._world,
                ],
            )
            if config.self_contact is not None:
                self._search()
            self._collect(contacts, state_in, state_out, dt)
            elements = max(len(sheet.triangle), len(sheet.hinge), len(sheet.edge))
            wp.launch(
                advance.begin_elements,
                dim=elements,
                inputs=[
                    sheet,
                    now,
                    self._second_order,
                    dt,
                    numbers.limit,
                    config.strain_stiffness_n_m,
                    config.strain_force_decay,
                    config.strain_stiffness_decay,
                ],
            )
            wp.launch(
                advance.guess,
                dim=count,
                inputs=[
                    sheet,
                    now,
                    self._layers,
                    self._guard,
                    dt,
                    config.warm_acceleration_g,
                    state_in.particle_qd,
                    model.gravity,
                    self._world,
                ],
            )
            shared = [sheet, now, numbers, self._solids, self._layers, self._guard]
            if self.fused:
                wp.launch(sweep.sweep_fused, dim=1, inputs=[*shared, config.iterations])
            else:
                for sweep_index in range(config.iterations):
                    wp.launch(sweep.sweep_hinges, dim=len(sheet.hinge), inputs=[sheet, now])
                    if self._layers.capacity:
                        wp.launch(
                            sweep.sweep_layers, dim=self._layers.capacity, inputs=[self._layers, now, sweep_index]
                        )
                    for colour in model.particle_color_groups:
                        wp.launch(sweep.sweep_colour, dim=len(colour), inputs=[colour, *shared])
                    wp.launch(sweep.sweep_limits, dim=len(sheet.edge), inputs=[sheet, now, numbers])
            wp.launch(
                advance.end_step,
                dim=count,
                inputs=[sheet, now, self._second_order, dt, state_in.particle_qd],
                outputs=[state_out.particle_q, state_out.particle_qd],
            )
        self.step_count += 1

    def rebuild_bvh(self) -> None:
        """Build the search trees of the self-contact anew; refitting alone makes them slow as the cloth folds."""
        if self.config.self_contact is not None:
            self._triangle_tree.rebuild()
            self._edge_tree.rebuild()

    def _numbers(self, dt: float) -> StepNumbers:
        config = self.config
        numbers = StepNumbers()
        numbers.rate = (1.5 if self._second_order else 1.0) / dt
        numbers.inertia = numbers.rate**2
        numbers.dt = dt
        numbers.step = self.step_count
        numbers.limit = 1.0 + config.max_strain
        numbers.edge_stiffness_max = config.strain_stiffness_max_n_m
        numbers.edge_growth = config.strain_growth_n_m2
        numbers.edge_share = config.strain_dual_share
        numbers.regularization = config.regularization
        numbers.friction_speed = config.friction_speed_m_s
        numbers.over_relaxation = config.over_relaxation
        return numbers

    def _search(self) -> None:
        settings = self.config.self_contact
        numbers = layers.LayerNumbers()
        numbers.radius, numbers.rest_exclusion = settings.radius_m, settings.rest_exclusion_m
        numbers.stiffness, numbers.damping, numbers.friction = (
            settings.stiffness_n_m,
            settings.damping_n_s_m,
            settings.friction,
        )
        sheet, now = self.sheet, self.now
        count = self.model.particle_count
        wp.launch(layers.decide_search, dim=count, inputs=[now, self._guard, self._due])
        wp.launch(
            layers.begin_search,
            dim=max(count, len(sheet.triangle), len(sheet.edge)),
            inputs=[
                now,
                self._due,
                self._guard,
                self._layers,
                sheet.triangle,
                sheet.edge,
                self._triangle_low,
                self._triangle_high,
                self._edge_low,
                self._edge_high,
            ],
        )
        self._triangle_tree.refit()
        self._edge_tree.refit()
        inputs = [self._group, sheet, self._rest, now, numbers, self._guard, self._layers]
        wp.launch(layers.find_vertex_triangle, dim=count, inputs=[self._due, self._triangle_tree.id, *inputs])
        wp.launch(layers.find_edge_edge, dim=len(sheet.edge), inputs=[self._due, self._edge_tree.id, *inputs])
        self._due.zero_()

    def _collect(self, contacts: Any, state_in: Any, state_out: Any, dt: float) -> None:
        self._solids.head.fill_(-1)
        self._solids.count.zero_()
        if contacts is None or not contacts.soft_contact_max:
            return
        model = self.model
        if self._solids.capacity < contacts.soft_contact_max:
            self._solids = _touches(model.particle_count, contacts.soft_contact_max)
        wp.launch(
            solids.collect_solids,
            dim=self._solids.capacity,
            inputs=[
                contacts.soft_contact_count,
                contacts.soft_contact_indices,
                contacts.soft_contact_barycentric,
                contacts.soft_contact_shape,
                contacts.soft_contact_body_pos,
                contacts.soft_contact_body_vel,
                contacts.soft_contact_normal,
                model.shape_body,
                model.shape_margin,
                model.shape_material_ke,
                model.shape_material_kd,
                model.shape_material_mu,
                model.particle_radius,
                state_in.body_q,
                state_out.body_q,
                dt,
                self.now,
                self._solids,
            ],
        )


def _iterate(model: Any, sheet: Any, config: AVBDConfig) -> Iterate:
    now = Iterate()
    count = model.particle_count
    now.x = wp.full(count, wp.vec3(float("nan")), dtype=wp.vec3)
    for name in ("target", "start", "before", "before_speed", "force"):
        setattr(now, name, wp.zeros(count, dtype=wp.vec3))
    now.slope = wp.zeros(count, dtype=wp.mat33)
    now.triangle_past = wp.zeros(len(sheet.triangle), dtype=wp.vec3)
    now.hinge_now = wp.clone(sheet.hinge_angle)
    now.hinge_past = wp.zeros(len(sheet.hinge), dtype=float)
    now.hinge_slope = wp.zeros((len(sheet.hinge), 4), dtype=wp.vec3)
    now.edge_force = wp.zeros(len(sheet.edge), dtype=float)
    now.edge_stiffness = wp.full(len(sheet.edge), config.strain_stiffness_n_m, dtype=float)
    now.edge_excess = wp.zeros(len(sheet.edge), dtype=float)
    now.broken = wp.zeros(3, dtype=wp.int32)
    return now


def _guard(model: Any, config: AVBDConfig) -> Guard:
    guard = Guard()
    guard.seen = wp.clone(model.particle_q)
    guard.safe = wp.zeros(model.particle_count, dtype=float)
    guard.cut = wp.zeros(1, dtype=wp.int32)
    if config.self_contact is not None:
        guard.reach, guard.share = config.self_contact.search_m, config.self_contact.share
    return guard


def _touches(vertex_count: int, capacity: int) -> Touches:
    touches = Touches()
    size = max(capacity, 1)
    touches.count = wp.zeros(1, dtype=wp.int32)
    touches.capacity = capacity
    touches.vertex = wp.zeros(size, dtype=wp.vec4i)
    for name in ("weight", "plane"):
        setattr(touches, name, wp.zeros(size, dtype=wp.vec4))
    for name in ("normal", "anchor"):
        setattr(touches, name, wp.zeros(size, dtype=wp.vec3))
    for name in ("offset", "stiffness", "damping", "friction"):
        setattr(touches, name, wp.zeros(size, dtype=float))
    for name in ("shape", "near", "first_side"):
        setattr(touches, name, wp.zeros(size, dtype=wp.int32))
    touches.head = wp.full(vertex_count, -1, dtype=wp.int32)
    touches.after = wp.full(4 * size, -1, dtype=wp.int32)
    return touches
