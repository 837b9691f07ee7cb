"""Numbers of the solver, and the paper's table of them."""

from dataclasses import dataclass, fields
from typing import Any, Literal, get_args

Integrator = Literal["implicit_euler", "bdf2"]

# The rest of the paper's table, which belongs to the model. Its bending energy is k l angle^2, newton's half of that.
PAPER_CLOTH = {  # for ModelBuilder.add_cloth_mesh
    "density": 2.0,  # kg/m^2
    "tri_ke": 1.0e2,  # shear modulus [N/m]
    "tri_ka": 1.0e2,  # area modulus [N/m]
    "tri_kd": 1.5e-6,
    "edge_ke": 2.0 * 8.0e-4,  # [N]
    "edge_kd": 1.0e-3,
    "particle_radius": 0.008,  # m
}
PAPER_ROBOT = {"ke": 5.0e2, "kd": 5.0e-3, "mu": 1.5}  # for ModelBuilder.ShapeConfig
PAPER_TABLE = {"ke": 5.0e2, "kd": 5.0e-3, "mu": 0.0}


@dataclass(frozen=True, kw_only=True)
class SelfContact:
    """How the cloth keeps off itself; defaults from the paper's table, appendix A."""

    radius_m: float = 0.002  # kept between two layers
    search_m: float = 0.008  # looked at around every vertex and edge; bounds the way between two searches
    rest_exclusion_m: float = 0.0  # pairs nearer than this at rest are neighbours, not contacts
    stiffness_n_m: float = 5.0e2
    damping_n_s_m: float = 5.0e-3  # of approach
    friction: float = 0.25
    share: float = 0.42  # beta: of the room to a neighbour that a vertex may use
    capacity_per_vertex: int = 24  # records; more pairs than that stop the simulation with an error

    def __post_init__(self) -> None:
        """Refuse what cannot be meant."""
        _refuse(self, "radius_m", "search_m", "share", "capacity_per_vertex")


@dataclass(frozen=True, kw_only=True)
class AVBDConfig:
    """Defaults are the paper's preset, appendix A, except where a comment says why not.

    The paper gives one beta in two places: `strain_growth_n_m2` ramps the penalty of the strain limit, 0.42 bounds the way of a
    vertex (`SelfContact.share`).
    """

    iterations: int = 10  # per step
    integrator: Integrator = "implicit_euler"
    max_strain: float = 0.05  # xi; infinity: no limit
    compression_share: float = 1.0  # of compressive strain that makes stress; below 1: finer wrinkles than the mesh has
    strain_stiffness_n_m: float = 1.0e4  # of the penalty at first
    strain_stiffness_max_n_m: float = 1.0e6
    strain_growth_n_m2: float = 1.0e3  # per metre of violation
    strain_dual_share: float = 0.1  # paper: 1, which explodes: one sweep is far from the minimum that the step assumes
    strain_force_decay: float = 0.94  # between steps
    strain_stiffness_decay: float = 0.95
    regularization: float = 0.0  # alpha, share of a violation at the start of a step that the step leaves; paper: 0.99
    friction_speed_m_s: float = 1.0e-2  # slip below this is regularised
    warm_acceleration_g: float = 1.0  # the first guess takes the last acceleration along up to this many times gravity
    nested_blocks: bool = True  # sweep over patches too, see `blocks.py`; paper: over vertices alone
    self_contact: SelfContact | None = None
    fused: bool | None = None  # one launch per step; None: on a CPU

    def __post_init__(self) -> None:
        """Refuse what cannot be meant."""
        if self.integrator not in get_args(Integrator):
            raise ValueError(f"integrator must be one of {get_args(Integrator)} (got {self.integrator!r})")
        _refuse(self, "iterations", "strain_stiffness_n_m", "strain_stiffness_max_n_m", "friction_speed_m_s")


def _refuse(numbers: Any, *above_zero: str) -> None:
    """All numbers must be at least zero, those named above it.

    Raises:
        ValueError: one is not, or is not a number.
    """
    for field in fields(numbers):
        value = getattr(numbers, field.name)
        if isinstance(value, int | float):
            positive = field.name in above_zero
            if not (value > 0.0 if positive else value >= 0.0):
                raise ValueError(f"{field.name} must be {'above' if positive else 'at least'} 0 (got {value})")
