"""`SolverAVBD`: cloth by augmented vertex block descent, as a newton solver."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import warp as wp
from newton.solvers import SolverBase

from sim1.cloth.avbd import advance, solids, sweep
from sim1.cloth.avbd.blocks import blocks_of
from sim1.cloth.avbd.buffers import Arguments, new_guard, new_iterate, new_touches
from sim1.cloth.avbd.curving import Curving
from sim1.cloth.avbd.iterate import StepNumbers
from sim1.cloth.avbd.parameters import AVBDConfig
from sim1.cloth.avbd.search import LayerSearch
from sim1.cloth.avbd.sheet import sheet_of
from sim1.cloth.avbd.threads import warp_of

if TYPE_CHECKING:
    from sim1.cloth.effects import Effect


@dataclass(frozen=True, kw_only=True)
class Broken:
    """The first value that was not a number."""

    vertex: int
    term: str  # inertia, effects, membrane, bending, strain limit, solid contact, self-contact; "their sum"
    step: int  # counted by the solver since it was made, or by the replays of a captured graph


class SolverAVBD(SolverBase):
    """Augmented vertex block descent for the triangles of a newton model.

    SIM1, appendix A, after AVBD (Giles et al. 2025) and VBD (Chen et al. 2024). On a CPU one launch sweeps the whole cloth; on
    a GPU the vertices of a colour move at once (call `ModelBuilder.color()`).

    The cloth touches every shape that a `newton.CollisionPipeline` finds. A shape's `ke`, `kd` and `mu` are those of the pair of
    shape and cloth, they are not mixed with another material. Bodies are where `state_in` and `state_out` have them; with
    `moves_bodies` those that are free and dynamic are moved by the solver, with the push of the cloth in the step before.

    Args:
        model: finalized newton model with triangles, without springs and tetrahedra.
        config: numbers; the default is the paper's preset.
        effects: physics beyond the plain model, acting in every step; the order in which they are given says nothing.
        table: number of the shape that is the table; effects of a table act on it alone.
        moves_bodies: integrate dynamic bodies too.

    Raises:
        ValueError: the model's vertices have no colours, an effect of a table is given and no table, or effects that ask for
            different warp directions.
    """

    def __init__(
        self,
        model: Any,
        config: AVBDConfig | None = None,
        *,
        effects: "tuple[Effect, ...]" = (),
        table: int | None = None,
        moves_bodies: bool = False,
    ) -> None:
        super().__init__(model)
        self.config, self.moves_bodies = config or AVBDConfig(), moves_bodies
        self.effects = tuple(sorted(effects, key=lambda effect: (-effect.rank, effect.name)))
        self.table, self.warp = table, warp_of(effects)
        lost = [effect.name for effect in effects if effect.on_table and table is None]
        if lost:
            raise ValueError(f"{' and '.join(lost)} act on a table; say which shape it is (table=)")
        self.fused = model.device.is_cpu if self.config.fused is None else self.config.fused
        self.second_order = int(self.config.integrator == "bdf2")
        self._step = 0
        self.memory: dict[str, list[wp.array]] = {}  # of effects, by name
        self.curving: Curving | None = None
        with wp.ScopedDevice(model.device):
            self._read_model()
            if not self.fused and not len(model.particle_color_groups):
                raise ValueError("the model's vertices have no colours; call ModelBuilder.color() before finalize()")
            self.now = new_iterate(model.particle_count, self.sheet, self.config)
            self.solids = new_touches(model.particle_count, 0)
            layers = self.config.self_contact
            self._layers = new_touches(
                model.particle_count, layers.capacity_per_vertex * model.particle_count if layers else 0
            )
            self._guard = new_guard(model, self.config)
            self._search = LayerSearch(model, self.sheet, layers) if layers else None
            self._pack()
            self._wrench = wp.zeros(max(model.body_count, 1), dtype=wp.spatial_vector)
            self._scratch = model.state() if moves_bodies else None

    def notify_model_changed(self, flags: Any) -> None:
        """Read materials and masses of the model anew; not within a captured graph."""
        with wp.ScopedDevice(self.model.device):
            self._read_model()
            self._pack()

    def step(self, state_in: Any, state_out: Any, control: Any, contacts: Any, dt: float) -> None:
        """Advance `state_in` to `state_out` by `dt` [s]; `contacts` of the collision pipeline or None. Can be captured."""
        model, config, given_sheet = self.model, self.config, self.sheet
        sheet, now = self._args.sheet, self._args.now
        numbers = self._numbers(dt)
        given = [state_in.particle_q, state_in.particle_qd, state_in.particle_f]
        world = [model.particle_inv_mass, model.particle_flags, model.gravity, model.particle_world]
        with wp.ScopedDevice(model.device):
            if self.moves_bodies:
                self._move_bodies(state_in, state_out, dt)
            wp.launch(
                advance.begin_step,
                dim=model.particle_count,
                inputs=[sheet, now, self.second_order, dt, *given, *world],
            )
            if self._search is not None:
                self._search.run(now, self._args.guard, self._args.layers, dt)
            self._collect(contacts, state_in, state_out, dt)
            decays = [config.strain_stiffness_n_m, config.strain_force_decay, config.strain_stiffness_decay]
            wp.launch(
                advance.begin_elements,
                dim=max(len(given_sheet.triangle), len(given_sheet.hinge), len(given_sheet.edge)),
                inputs=[sheet, now, self.second_order, dt, 1.0 + config.max_strain, config.regularization, *decays],
            )
            if self.curving is not None:
                self.curving.look(self.sheet, self.now, dt)
            for effect in self.effects:
                effect.push(self, dt)
            wp.launch(
                advance.guess,
                dim=model.particle_count,
                inputs=[
                    sheet,
                    now,
                    self._args.solids,
                    int(self._search is None),
                    dt,
                    config.warm_acceleration_g,
                    given[1],
                    *world[2:],
                ],
            )
            self._sweep(numbers)
            wp.launch(
                advance.end_step,
                dim=model.particle_count,
                inputs=[sheet, now, self.second_order, dt, state_in.particle_qd],
                outputs=[state_out.particle_q, state_out.particle_qd],
            )
            if self.moves_bodies and contacts is not None:
                self._feel_cloth(contacts, state_out, numbers)
        self._step += 1

    def reset(self, state: Any, world_mask: Any = None, flags: Any = None) -> None:
        """Forget all history; for a cloth that is put somewhere else. One world alone cannot be reset.

        Raises:
            ValueError: `world_mask` is given.
        """
        if world_mask is not None:
            raise ValueError("world_mask: SolverAVBD resets all worlds at once; pass None")
        now = self.now
        now.x.fill_(wp.vec3(float("nan")))
        wp.copy(now.hinge_now, self.sheet.hinge_angle if self.curving is None else self.curving.rest)
        for arrays in self.memory.values():
            for array in arrays:
                array.zero_()
        now.edge_force.zero_()
        now.edge_stiffness.fill_(self.config.strain_stiffness_n_m)
        now.broken.zero_()
        self._guard.cut.fill_(1)
        if self._search is not None:
            self._search.reset(state.particle_q)

    def rebuild_bvh(self) -> None:
        """Build the search trees of the self-contact anew, now and then; refitting alone makes them slow as cloth folds."""
        if self._search is not None:
            self._search.rebuild()

    def rate(self, dt: float) -> float:
        """Factor of a value in its rate at the end of a step [1/s]: 1 / dt, or 3 / (2 dt) for BDF2."""
        return (1.5 if self.second_order else 1.0) / dt

    def broken(self) -> Broken | None:
        """What became not a number first; None while all is well. Waits for the device.

        Raises:
            RuntimeError: more pairs of layers were near each other than there is room for.
        """
        vertex, term, step = (int(value) for value in self.now.broken.numpy())
        if vertex:
            return Broken(vertex=vertex - 1, term=sweep.TERMS[term] if term >= 0 else "their sum", step=step)
        found = int(self._layers.count.numpy()[0])
        if found > self._layers.capacity:
            raise RuntimeError(
                f"self-contact: {found} pairs are near each other, room is for {self._layers.capacity}; "
                "raise SelfContact.capacity_per_vertex or lower search_m"
            )
        return None

    def curves(self, effect: str, *, tensors: int) -> Curving:
        """For an effect that acts on curvature: how edges lie, and `memory[effect]` of so many tensors (v,), 0 after a reset.

        To be asked in `shape`, before the stiffness of hinges is changed there.
        """
        if self.curving is None:
            self.curving = Curving.of(self.sheet, self.hinge_corners_m, self.warp)
        self.memory[effect] = [wp.zeros(self.model.particle_count, dtype=wp.vec3) for _ in range(tensors)]
        return self.curving

    def _read_model(self) -> None:
        self.sheet = sheet_of(self.model, self.config.compression_share)
        self.hinge_corners_m = self.model.particle_q.numpy()[self.sheet.hinge.numpy()].astype(
            float
        )  # (h, 4, 3), at rest
        self.curving = None
        for effect in self.effects:
            effect.shape(self)
        if self.curving is not None:
            wp.copy(self.curving.rest, self.sheet.hinge_angle)
        self._blocks, coarse = blocks_of(
            self.sheet, self.model.particle_world.numpy(), nested=self.config.nested_blocks
        )
        self._colours = [*self.model.particle_color_groups, *(wp.array(ids, dtype=wp.int32) for ids in coarse)]

    def _pack(self) -> None:
        self._args = Arguments.of(self.sheet, self._blocks, self.now, self.solids, self._layers, self._guard)

    def _numbers(self, dt: float) -> StepNumbers:
        config = self.config
        numbers = StepNumbers()
        numbers.rate, numbers.dt, numbers.step = self.rate(dt), dt, self._step
        numbers.inertia = numbers.rate**2
        numbers.edge_stiffness_max = config.strain_stiffness_max_n_m
        numbers.edge_growth, numbers.edge_share = config.strain_growth_n_m2, config.strain_dual_share
        numbers.friction_speed = config.friction_speed_m_s
        return numbers

    def _sweep(self, numbers: StepNumbers) -> None:
        args = self._args
        self._layers.head.fill_(-1)
        shared = [args.sheet, args.blocks, args.now, numbers, args.solids, args.layers, args.guard]
        if self.fused:
            wp.launch(sweep.sweep_fused, dim=1, inputs=[*shared, self.config.iterations])
            return
        if self._search is not None:
            for colour in reversed(self._colours):
                wp.launch(
                    sweep.follow_colour,
                    dim=len(colour),
                    inputs=[colour, args.sheet, args.blocks, args.now, args.layers, args.guard],
                )
        for index in range(self.config.iterations):
            if index % 2 == 0:
                wp.launch(sweep.sweep_hinges, dim=len(self.sheet.hinge), inputs=[args.sheet, args.now, numbers])
            if self._layers.capacity:
                wp.launch(sweep.sweep_layers, dim=self._layers.capacity, inputs=[args.layers, args.now, index])
            fine = len(self.model.particle_color_groups)
            for colour in self._colours if index % sweep.COARSE_EVERY == 0 else self._colours[:fine]:
                wp.launch(sweep.sweep_colour, dim=len(colour), inputs=[colour, *shared])
            wp.launch(sweep.sweep_limits, dim=len(self.sheet.edge), inputs=[args.sheet, args.now, numbers])

    def _collect(self, contacts: Any, state_in: Any, state_out: Any, dt: float) -> None:
        self.solids.head.fill_(-1)
        if contacts is None or not contacts.soft_contact_max:
            return
        model = self.model
        if self.solids.capacity < contacts.soft_contact_max:
            self.solids = new_touches(model.particle_count, contacts.soft_contact_max)
            self._pack()
        names = ("count", "indices", "barycentric", "shape", "body_pos", "body_vel", "normal")
        found = [getattr(contacts, f"soft_contact_{name}") for name in names]
        material = [model.shape_body, model.shape_margin, model.shape_material_ke, model.shape_material_kd]
        material += [model.shape_material_mu, model.particle_radius]
        wp.launch(
            solids.collect_solids,
            dim=self.solids.capacity,
            inputs=[*found, *material, state_in.body_q, state_out.body_q, dt, self._args.now, self._args.solids],
        )

    def _move_bodies(self, state_in: Any, state_out: Any, dt: float) -> None:
        model, scratch = self.model, self._scratch
        wp.launch(solids.load_bodies, dim=model.body_count, inputs=[state_in.body_f, self._wrench, scratch.body_f])
        wp.copy(scratch.body_q, state_in.body_q)
        wp.copy(scratch.body_qd, state_in.body_qd)
        self.integrate_bodies(model, scratch, scratch, dt)
        wp.launch(
            solids.take_dynamic,
            dim=model.body_count,
            inputs=[model.body_inv_mass, model.body_flags, scratch.body_q, scratch.body_qd],
            outputs=[state_out.body_q, state_out.body_qd],
        )

    def _feel_cloth(self, contacts: Any, state_out: Any, numbers: StepNumbers) -> None:
        self._wrench.zero_()
        bodies = [self.model.shape_body, state_out.body_q, self.model.body_com]
        wp.launch(
            solids.push_back,
            dim=self.solids.capacity,
            inputs=[self._args.now, numbers, self._args.solids, contacts.soft_contact_count, *bodies],
            outputs=[self._wrench],
        )
