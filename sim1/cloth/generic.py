"""newton's own cloth solver in the cell, to show what the project's solver is worth.

It has no strain limit, and it brakes a sliding sheet harder than its friction coefficient says (0.7 of the way, a test).
"""

from typing import Any

from sim1.cloth.config import CellConfig


class GenericCloth:
    """`SolverVBD` behind what the cell asks of a solver. Its membrane is Neo-Hookean; it acts no named physics."""

    def __init__(self, model: Any, config: CellConfig, friction: float, rest_exclusion_m: float) -> None:
        """Self-contact as the project's own solver has it, so that the two differ in nothing but the solver.

        Args:
            model: newton model of the cell.
            config: the cell's settings.
            friction: coefficient between layers.
            rest_exclusion_m: vertices nearer than this in the rest shape do not collide.
        """
        from newton.solvers import SolverBase, SolverVBD

        _mix_materials(model, config.self_stiffness_n_m, friction)
        contact: dict[str, Any] = {}
        if config.self_contact:
            contact = {
                "particle_enable_self_contact": True,
                "particle_self_contact_margin": config.self_margin_m,
                "particle_self_contact_gap": config.self_search_m - config.self_margin_m,
                "particle_rest_shape_contact_exclusion_radius": rest_exclusion_m,
                "particle_topological_contact_filter_threshold": 1,
                "collision_frequency_type": {
                    SolverBase.CollisionSlot.SOFT_SELF_CONTACT: SolverBase.CollisionFrequencyType.PRE_INIT
                },
            }
        self._solver = SolverVBD(
            model, iterations=config.iterations, integrate_with_external_rigid_solver=True, **contact
        )
        self._self_contact = config.self_contact
        self._state: Any = None

    def reset(self, state: Any) -> None:
        """Start from `state`; the solver keeps nothing from one step to the next but its search trees."""
        self._state = state
        self.rebuild_bvh()

    def rebuild_bvh(self) -> None:
        """Build the search trees of the self-contact anew."""
        if self._self_contact:
            self._solver.rebuild_bvh(self._state)

    def step(self, now: Any, then: Any, control: Any, contacts: Any, dt: float) -> None:
        """Advance `now` by dt [s] into `then`."""
        self._solver.step(now, then, control, contacts, dt)

    def broken(self) -> None:
        """It does not watch itself; the cell sees positions that are not sensible."""


def _mix_materials(model: Any, stiffness_n_m: float, friction: float) -> None:
    """Let cloth on a shape have that shape's stiffness and friction.

    This solver takes the mean of the cloth's and the shape's stiffness, and the geometric mean of their friction.
    """
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = stiffness_n_m, 0.0, friction
    model.shape_material_ke.assign(2.0 * model.shape_material_ke.numpy() - stiffness_n_m)
    model.shape_material_kd.assign(2.0 * model.shape_material_kd.numpy())
    model.shape_material_mu.assign(model.shape_material_mu.numpy() ** 2 / friction)
