"""The one place that names a cloth solver; another one takes its place here."""

from dataclasses import dataclass
from typing import Any, Literal, Protocol

type SolverName = Literal["vbd"]


class ClothSolver(Protocol):
    """What the world asks of a solver."""

    def step(self, state_in: Any, state_out: Any, control: Any, contacts: Any, dt: float) -> None:
        """Advance `state_in` to `state_out` by `dt` [s]; rigid bodies move as both states say."""

    def rebuild_bvh(self, state: Any) -> None:
        """Rebuild the search tree of the self-contact."""


@dataclass(frozen=True, kw_only=True)
class SelfContact:
    """How the cloth keeps off itself."""

    margin_m: float  # distance at which two layers start to push
    search_gap_m: float  # further distance that detection looks ahead
    rest_exclusion_m: float  # pairs closer than this in the rest shape are neighbours, not contacts


def make_solver(
    model: Any, name: SolverName, *, iterations: int, friction_speed_m_s: float, self_contact: SelfContact | None
) -> ClothSolver:
    """Make the cloth solver of that name for a finalized, coloured newton model.

    Rigid bodies are moved from outside (one-way coupling): robot links act on the cloth, not the reverse.
    """
    if name != "vbd":
        raise ValueError(f"unknown cloth solver {name!r}, expected 'vbd'")
    from newton.solvers import SolverBase, SolverVBD

    options: dict[str, Any] = {}
    if self_contact is not None:
        options = {
            "particle_enable_self_contact": True,
            "particle_self_contact_margin": self_contact.margin_m,
            "particle_self_contact_gap": self_contact.search_gap_m,
            "particle_rest_shape_contact_exclusion_radius": self_contact.rest_exclusion_m,
            "particle_topological_contact_filter_threshold": 1,
            "particle_vertex_contact_buffer_size": 32,
            "particle_edge_contact_buffer_size": 48,
            "collision_frequency_type": {
                SolverBase.CollisionSlot.SOFT_SELF_CONTACT: SolverBase.CollisionFrequencyType.PRE_INIT
            },
        }
    return SolverVBD(
        model,
        iterations=iterations,
        friction_epsilon=friction_speed_m_s,
        integrate_with_external_rigid_solver=True,
        **options,
    )
