"""Mechanical properties of a garment, and how they become the parameters of the cloth solver."""

import math
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import yaml

from sim1.stage import BadInput

SCHEMA = "sim1.model/1"
SCALARS = ("area_density_kg_m2", "thickness_m", "stretch_n_m", "poisson", "bending_n_m", "damping_s")
CONTACTS = ("table", "robot", "self")
MESH = ("length_u", "length_v", "clamp", "rim")
MOST_REFINED = 3  # 64 faces for one: more is a slip
PRIOR_FRICTION = {"table": 0.4, "robot": 1.5, "self": 0.25}  # cotton on wood, on rubber finger pads, on cotton


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
    """Physics from the prior means of a garment file's `fabric` block; no intervals, prior friction."""
    return _from_mapping({**fabric, "friction": {}, "effects": []}, "fabric", strict=False)


def read_physics(path: Path) -> ClothPhysics:
    """Read `model.yaml`.

    Raises:
        BadInput: not readable, wrong schema, unknown or missing key, value out of range.
    """
    try:
        content = yaml.safe_load(path.read_text())
    except (OSError, yaml.YAMLError) as error:
        raise BadInput(f"{path}: not a readable model file ({error}); make it again") from error
    return physics_of_record(content, str(path))


def write_physics(path: Path, physics: ClothPhysics) -> None:
    """Write `model.yaml`; reading it back gives an equal object."""
    path.write_text(yaml.safe_dump(physics_record(physics), sort_keys=False))


def physics_of_record(content: Any, where: str) -> ClothPhysics:
    """Physics from the contents of a model file, wherever they are kept; `where` is named in what is raised.

    Raises:
        BadInput: wrong schema, unknown or missing key, value out of range.
    """
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        found = content.get("schema") if isinstance(content, dict) else content
        raise BadInput(f"{where}: schema is {found!r}, expected {SCHEMA!r}")
    return _from_mapping({key: value for key, value in content.items() if key != "schema"}, where, strict=True)


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


def _from_mapping(content: dict[str, Any], where: str, *, strict: bool) -> ClothPhysics:
    known = {field.name for field in fields(ClothPhysics)}
    missing = [name for name in (*SCALARS, "friction") if name not in content]
    unknown = sorted(set(content) - known)
    if missing or (strict and unknown):
        raise BadInput(f"{where}: missing keys {missing}, unknown keys {unknown}; expected {sorted(known)}")
    scalars = {name: _property(content[name], f"{where}: {name}", strict) for name in SCALARS}
    for name, item in scalars.items():
        low, high = (-0.99, 0.99) if name == "poisson" else (0.0, math.inf)
        if not low <= item.value < high or (name not in ("poisson", "damping_s", "bending_n_m") and item.value == 0.0):
            raise BadInput(f"{where}: {name} is {item.value}, expected a value in [{low}, {high}) in SI units")
    contacts = content["friction"] or {}
    wrong = sorted(set(contacts) - set(CONTACTS)) + ([] if not strict else sorted(set(CONTACTS) - set(contacts)))
    if wrong:
        raise BadInput(f"{where}: friction has unknown or missing entries {wrong}; expected {list(CONTACTS)}")
    friction = Friction(**{name: _property(contacts[name], f"{where}: friction.{name}", strict) for name in contacts})
    for name in CONTACTS:
        if getattr(friction, name).value < 0.0:
            raise BadInput(f"{where}: friction.{name} is {getattr(friction, name).value}, expected at least 0")
    return ClothPhysics(
        **scalars,
        friction=friction,
        effects=tuple(content.get("effects") or ()),
        grips=_grips(content.get("grips") or (), where),
        mesh=_mesh(content.get("mesh") or {}, where),
        mesh_refined=_refined(content.get("mesh_refined"), where),
    )


def _refined(value: Any, where: str) -> int | None:
    if value is not None and (isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MOST_REFINED):
        raise BadInput(f"{where}: mesh_refined is {value!r}, expected a whole number from 0 to {MOST_REFINED}")
    return value


def _mesh(entries: Any, where: str) -> dict[str, float]:
    if not isinstance(entries, dict) or not set(entries) <= set(MESH):
        raise BadInput(f"{where}: mesh holds {entries!r}, expected factors named {list(MESH)}")
    for name, value in entries.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
            raise BadInput(f"{where}: mesh.{name} is {value!r}, expected a positive number")
    return {name: float(value) for name, value in entries.items()}


def _grips(entries: Any, where: str) -> tuple[dict[str, Any], ...]:
    for entry in entries:
        if not isinstance(entry, dict) or set(entry) - {"recording"} != {"drive", "vertices", "places_m"}:
            raise BadInput(
                f"{where}: grips holds {entry!r}, expected {{drive, vertices, places_m}} and perhaps recording"
            )
        if len(entry["vertices"]) != len(entry["places_m"]) or any(len(row) != 3 for row in entry["places_m"]):
            raise BadInput(
                f"{where}: grips: drive {entry['drive']!r} has not one place (x, y, z) for each of its vertices"
            )
    return tuple(entries)


def _property(item: Any, where: str, strict: bool) -> Property:
    """`strict`: exactly value and ci95 (model files); else other keys (a prior's spread) are left aside."""
    if not isinstance(item, dict) or "value" not in item or (strict and set(item) != {"value", "ci95"}):
        raise BadInput(f"{where}: {item!r} is not {{value: number, ci95: [low, high] or null}}")
    value, interval = item["value"], item.get("ci95") if strict else None
    numbers = [value, *(interval or [])]
    if any(isinstance(x, bool) or not isinstance(x, int | float) or not math.isfinite(x) for x in numbers):
        raise BadInput(f"{where}: {item!r} holds something that is not a finite number")
    if interval is not None and (len(interval) != 2 or interval[0] > interval[1]):
        raise BadInput(f"{where}: ci95 is {interval}, expected [low, high]")
    return Property(value=float(value), ci95=None if interval is None else (float(interval[0]), float(interval[1])))
