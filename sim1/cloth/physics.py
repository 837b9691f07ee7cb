"""Mechanical properties of a garment, and how they become the parameters of the cloth solver."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from sim1.cloth.physics_document import SCHEMA, AnyPart, MeshPart, PhysicsDocument
from sim1.data_file import explained, read_yaml
from sim1.stage import BadInput

SCALARS = ("area_density_kg_m2", "thickness_m", "stretch_n_m", "poisson", "bending_n_m", "damping_s")
CONTACTS = ("table", "robot", "self")
MESH = tuple(MeshPart.model_fields)
PRIOR_FRICTION = {"table": 0.4, "robot": 1.5, "self": 0.25}  # cotton on wood, on rubber finger pads, on cotton
REMEDY = "write it as docs/artifacts.md shows, or make it again"


@dataclass(frozen=True, kw_only=True)
class Property:
    """A value and its 95 % interval; no interval where nothing was measured (a prior)."""

    value: float
    ci95: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Friction:
    """Coulomb coefficients of the garment against what it touches."""

    table: Property = Property(value=PRIOR_FRICTION["table"])
    robot: Property = Property(value=PRIOR_FRICTION["robot"])
    self: Property = Property(value=PRIOR_FRICTION["self"])


@dataclass(frozen=True, kw_only=True)
class ClothPhysics:
    """A garment's `model.yaml` (`sim1.model/1`): fabric properties, friction, and named effects."""

    area_density_kg_m2: Property
    thickness_m: Property
    stretch_n_m: Property  # membrane stiffness: Young's modulus times thickness [N/m]
    poisson: Property
    bending_n_m: Property  # plate rigidity D, moment per width over curvature [N m]
    damping_s: Property  # Kelvin-Voigt time: viscous stress = damping_s * rate of the elastic stress
    friction: Friction = Friction()
    effects: tuple[dict[str, Any], ...] = ()
    grips: tuple[
        dict[str, Any], ...
    ] = ()  # {drive, vertices, places_m}, perhaps recording: a lab's grips that calibration found
    mesh: dict[str, float] = field(
        default_factory=dict
    )  # what the identification simulator's own mesh was found to get wrong
    mesh_refined: int | None = None  # how often every face of the bundle's mesh was cut into four there; None: not said

    def with_values(self, **values: float) -> "ClothPhysics":
        """The same fabric with some scalar values replaced; their intervals are dropped."""
        return replace(self, **{name: Property(value=value) for name, value in values.items()})


@dataclass(frozen=True, kw_only=True)
class MembraneParameters:
    """Plane-stress Lame parameters of the membrane and its viscosity."""

    mu_n_m: float
    lambda_n_m: float
    viscosity_n_s_m: float


def membrane(physics: ClothPhysics) -> MembraneParameters:
    """Lame parameters [N/m] from E h and the Poisson ratio in plane stress.

    mu = E h / (2 (1 + nu)); lambda = E h nu / (1 - nu^2). The solver's Neo-Hookean membrane has exactly these small
    strain moduli. Its damping force is `kd` times the rate of C = F^T F, that is a viscous stress of 4 kd d(strain)/dt;
    Kelvin-Voigt asks for damping_s * 2 mu d(strain)/dt, hence kd = damping_s * mu / 2.
    """
    stiffness, poisson = physics.stretch_n_m.value, physics.poisson.value
    mu = stiffness / (2.0 * (1.0 + poisson))
    return MembraneParameters(
        mu_n_m=mu,
        lambda_n_m=stiffness * poisson / (1.0 - poisson**2),
        viscosity_n_s_m=0.5 * physics.damping_s.value * mu,
    )


def nominal_from_priors(fabric: dict[str, Any]) -> ClothPhysics:
    """Physics from the prior means of a garment file's `fabric` block; no intervals, prior friction.

    Raises:
        BadInput: a value out of range.
    """
    values = {name: {"value": fabric[name]["value"], "ci95": None} for name in SCALARS}
    friction = {name: {"value": value, "ci95": None} for name, value in PRIOR_FRICTION.items()}
    return physics_of_record({"schema": SCHEMA, **values, "friction": friction}, "fabric")


def read_physics(path: Path) -> ClothPhysics:
    """Read `model.yaml`.

    Raises:
        BadInput: not readable, a key twice, or what `physics_of_record` refuses.
    """
    return physics_of_record(read_yaml(path), str(path))


def write_physics(path: Path, physics: ClothPhysics) -> None:
    """Write `model.yaml`; reading it back gives an equal object."""
    path.write_text(yaml.safe_dump(physics_record(physics), sort_keys=False))


def physics_of_record(content: Any, where: str) -> ClothPhysics:
    """Physics from the contents of a model file, wherever they are kept; `where` is named in what is raised.

    Raises:
        BadInput: wrong schema, unknown or missing key, a value of another type or out of range, an effect that is not known, or one with
            parameters, units or values that it cannot have.
    """
    from sim1.cloth.effects import effects_of  # brings the solver's kernels along

    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        found = content.get("schema") if isinstance(content, dict) else content
        raise BadInput(f"{where}: schema is {found!r:.80}, expected {SCHEMA!r}; {REMEDY}")
    try:
        document = PhysicsDocument.model_validate({key: value for key, value in content.items() if key != "schema"})
    except ValidationError as error:
        raise BadInput(f"{where}: {explained(error)}; {REMEDY}") from error
    effects = tuple(effect.model_dump() for effect in document.effects)
    effects_of(effects, f"{where}: effects")
    return ClothPhysics(
        **{name: _property(getattr(document, name)) for name in SCALARS},
        friction=Friction(**{name: _property(getattr(document.friction, name)) for name in CONTACTS}),
        effects=effects,
        grips=tuple(grip.model_dump(exclude_none=True) for grip in document.grips),
        mesh=document.mesh.model_dump(exclude_none=True),
        mesh_refined=document.mesh_refined,
    )


def physics_record(physics: ClothPhysics) -> dict[str, Any]:
    """The contents of a model file, in JSON's types; `physics_of_record` gives an equal object."""
    content: dict[str, Any] = {"schema": SCHEMA}
    content |= {name: _to_mapping(getattr(physics, name)) for name in SCALARS}
    content["friction"] = {name: _to_mapping(getattr(physics.friction, name)) for name in CONTACTS}
    content["effects"] = [dict(effect) for effect in physics.effects]
    if physics.grips:
        content["grips"] = [dict(grip) for grip in physics.grips]
    if physics.mesh:
        content["mesh"] = dict(physics.mesh)
    if physics.mesh_refined is not None:
        content["mesh_refined"] = physics.mesh_refined
    return content


def _to_mapping(item: Property) -> dict[str, Any]:
    return {"value": float(item.value), "ci95": None if item.ci95 is None else [float(edge) for edge in item.ci95]}


def _property(part: AnyPart) -> Property:
    return Property(value=part.value, ci95=None if part.ci95 is None else tuple(part.ci95))
