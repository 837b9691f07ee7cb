"""The solvers under comparison, each made to hold a corner, pull it and say where the cloth is."""

from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np

from benchmarks.solver import newton_run, scenes

SPEED_M_S = 0.5  # of the pulled corner, along x
RAMP_S = 0.1  # it takes to get there
MAX_STRAIN = 0.05  # the paper's limit
type Kind = Literal[
    "SolverAVBD",
    "SolverAVBD, vertices alone",  # as in the paper: without nested blocks
    "SolverVBD",
    "SolverStyle3D",
    "MuJoCo elastic",
    "MuJoCo edges",  # as they come; the next two: as stiff as a step allows, with this impedance
    "MuJoCo edges 0.99",
    "MuJoCo edges 0.9999",
]


@dataclass(frozen=True, kw_only=True)
class Contestant:
    """A solver and its settings."""

    kind: Kind
    iterations: int = 1  # MuJoCo: solves each step to the end, no number of iterations is set
    steps_per_s: int = 600
    modulus_n_m: float = scenes.MODULUS_N_M
    max_strain: float = MAX_STRAIN  # of SolverAVBD alone

    @property
    def name(self) -> str:
        """Shown in the table and the picture."""
        return self.kind if self.kind.startswith("MuJoCo") else f"{self.kind}, {self.iterations} it."


class Run(Protocol):
    """A cloth that is being pulled."""

    seconds: float  # of the processor, spent in steps so far
    steps: int

    def advance(self) -> None:
        """Two steps."""
        ...

    def points(self) -> np.ndarray:
        """Where the cloth is, (v, 3) [m]."""
        ...


def start(contestant: Contestant, cloth: scenes.Cloth, device: str = "cpu") -> Run:
    """The pull of `cloth` by a contestant, at its beginning; MuJoCo has no device."""
    dt_s = 1.0 / contestant.steps_per_s
    if contestant.kind.startswith("MuJoCo"):
        from benchmarks.solver.mujoco_run import MujocoRun

        return MujocoRun(cloth, dt_s, contestant.kind, contestant.modulus_n_m)
    style3d = contestant.kind == "SolverStyle3D"
    model = scenes.newton_model(cloth, modulus_n_m=contestant.modulus_n_m, style3d=style3d, device=device)
    solver = newton_solver(contestant.kind, model, contestant.iterations, max_strain=contestant.max_strain)
    return newton_run.NewtonRun(model, solver, dt_s, scenes.held_in(cloth, 1), graph=not style3d)


def newton_solver(
    kind: str, model: Any, iterations: int, layers: "Layers | None" = None, max_strain: float = MAX_STRAIN
) -> Any:
    """A newton solver of that kind, with self-contact where `layers` are given."""
    from newton.solvers import SolverBase, SolverStyle3D, SolverVBD

    from sim1.cloth.avbd import AVBDConfig, SelfContact, SolverAVBD

    if kind.startswith("SolverAVBD"):
        contact = None
        if layers is not None:
            contact = SelfContact(
                radius_m=layers.radius_m,
                search_m=layers.search_m,
                rest_exclusion_m=layers.rest_exclusion_m,
                stiffness_n_m=layers.stiffness_n_m,
                damping_n_s_m=0.0,
                friction=layers.friction,
            )
        config = AVBDConfig(
            iterations=iterations, max_strain=max_strain, nested_blocks=kind == "SolverAVBD", self_contact=contact
        )
        return SolverAVBD(model, config)
    if kind == "SolverStyle3D":
        solver = SolverStyle3D(model, config=SolverStyle3D.Config(iterations=iterations))
        solver.collision = None  # nothing touches anything in the pull; the others do not look either
        return solver
    options: dict[str, Any] = {}
    if layers is not None:
        model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = layers.stiffness_n_m, 0.0, layers.friction
        options = {
            "particle_enable_self_contact": True,
            "particle_self_contact_margin": layers.radius_m,
            "particle_self_contact_gap": layers.search_m - layers.radius_m,
            "particle_rest_shape_contact_exclusion_radius": layers.rest_exclusion_m,
            "particle_topological_contact_filter_threshold": 1,
            "collision_frequency_type": {
                SolverBase.CollisionSlot.SOFT_SELF_CONTACT: SolverBase.CollisionFrequencyType.PRE_INIT
            },
        }
    return SolverVBD(model, iterations=iterations, integrate_with_external_rigid_solver=True, **options)


@dataclass(frozen=True, kw_only=True)
class Layers:
    """Self-contact, alike for all."""

    radius_m: float = 0.003  # at which two layers start to push
    search_m: float = 0.006  # looked at around every vertex and edge
    rest_exclusion_m: float = 0.006
    stiffness_n_m: float = 200.0
    friction: float = 0.25


def corner_way_m(time_s: float) -> float:
    """How far the corner has been pulled."""
    late = max(time_s - RAMP_S, 0.0)
    early = min(time_s, RAMP_S)
    return SPEED_M_S * (0.5 * early * early / RAMP_S + late)
