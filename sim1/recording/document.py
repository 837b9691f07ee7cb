"""`bundle.yaml`: everything of a recording bundle that is not a time series, checked strictly."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

import pydantic
import yaml

from sim1.recording.problems import Several
from sim1.recording.strict_yaml import Strict, read_strict

SCHEMA = "sim1.recordings/1"

LARGEST = {  # of any fabric, with room: beyond it a value is in another unit
    "area_density_kg_m2": 5.0,
    "thickness_m": 0.05,
    "stretch_n_m": 1e6,
    "poisson": 0.5,
    "bending_n_m": 10.0,
    "damping_s": 10.0,
}
LARGEST_NOISE_M = 0.05  # a marker that scatters more is not tracked
FARTHEST_PLACE_M = 2.0  # of cloth from the frame of the gripper that holds it

type Vector = tuple[float, float, float]
type Name = Annotated[str, pydantic.Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")]


class Prior(Strict):
    """A value and how sure one is of it: `std` in the same unit, or `log_std` of its natural logarithm."""

    value: pydantic.PositiveFloat
    std: pydantic.PositiveFloat | None = None
    log_std: pydantic.PositiveFloat | None = None

    @property
    def spread(self) -> float | None:
        """Standard deviation in the value's own unit; None where none is stated, or one of the logarithm of nothing."""
        return self.std or (self.log_std or 0.0) * self.value or None

    @property
    def log_spread(self) -> float | None:
        """Standard deviation of the natural logarithm; None where none is stated, or the value is 0."""
        return self.log_std or (self.std / self.value if self.std and self.value else None)


class Priors(Strict):
    """What a data sheet or a kitchen scale says of the fabric, SI units."""

    area_density_kg_m2: Prior
    thickness_m: Prior
    stretch_n_m: Prior
    poisson: Prior
    bending_n_m: Prior
    damping_s: Prior


class GarmentPart(Strict):
    """The recorded cloth: its mesh file and priors."""

    mesh: str
    prior: Priors


class Friction(Prior):
    """Friction coefficient, which may be 0."""

    value: pydantic.NonNegativeFloat


class Table(Strict):
    """A horizontal table top."""

    height_m: float
    friction: Friction


class Environment(Strict):
    """Gravity, air and table."""

    gravity_m_s2: Vector
    air_density_kg_m3: pydantic.NonNegativeFloat
    table: Table | None


class MarkersPart(Strict):
    """Noise of the markers, standard deviation per coordinate; null where nobody knows it."""

    noise_std_m: pydantic.PositiveFloat | None


class HoldPart(Strict):
    """Vertices that move rigidly with a drive from `from_s` to `to_s`."""

    drive: str
    vertices: Annotated[list[pydantic.NonNegativeInt], pydantic.Field(min_length=1)]
    from_s: float
    to_s: float
    places_m: list[Vector] | None = None  # in the drive's frame; null: not measured


class RecordingPart(Strict):
    """One recorded motion."""

    name: Name  # also the folder's name
    starts: Literal["rest", "moving"]
    holds: list[HoldPart]


class Document(Strict):
    """Contents of `bundle.yaml`."""

    schema_: Literal["sim1.recordings/1"] = pydantic.Field(alias="schema")
    garment: GarmentPart
    environment: Environment
    markers: MarkersPart
    recordings: Annotated[list[RecordingPart], pydantic.Field(min_length=1)]


def read_document(path: Path, named: Path) -> Document:
    """Read and check `bundle.yaml`; `named` is the file whose words it repeats: itself, or that of an import.

    Raises:
        BadInput: missing, not YAML, an unknown, missing or repeated key, a value out of range; names the key.
    """
    document = read_strict(path, Document, f"bundle.yaml, schema {SCHEMA}")
    if wrong := list(_wrong(named, document)):
        raise Several(wrong)
    return document


def write_document(path: Path, document: Document) -> None:
    """Write `bundle.yaml`, keys in the order of the schema."""
    text = yaml.safe_dump(
        document.model_dump(by_alias=True, mode="json"), sort_keys=False, default_flow_style=None, width=120
    )
    path.write_text(text)


def _wrong(path: Path, document: Document) -> Iterator[str]:
    names = [recording.name for recording in document.recordings]
    if len(set(names)) != len(names):
        yield f"{path}: recordings: a name occurs twice in {names}; every recording needs its own"
    if not re.fullmatch(r"[\w.-]+", document.garment.mesh) or document.garment.mesh.startswith("."):
        yield f"{path}: garment.mesh is {document.garment.mesh!r}; name a file inside the bundle"
    yield from wrong_priors(path, document.garment.prior)
    yield from wrong_environment(path, document.environment)
    noise = document.markers.noise_std_m
    if noise is not None and noise > LARGEST_NOISE_M:
        yield f"{path}: markers.noise_std_m is {noise}; expected at most {LARGEST_NOISE_M} m: is it in millimetres?"
    for recording in document.recordings:
        yield from wrong_holds(f"{path}: recording {recording.name}", recording.holds)


def wrong_priors(path: Path, prior: Priors) -> Iterator[str]:
    """What is wrong with the priors: values that no fabric has, two spreads of one value."""
    for key, most in LARGEST.items():
        part: Prior = getattr(prior, key)
        if part.value > most:
            yield f"{path}: garment.prior.{key} is {part.value}; expected at most {most}, in SI units"
        if part.std is not None and part.log_std is not None:
            yield f"{path}: garment.prior.{key} has std {part.std} and log_std {part.log_std}; keep one of them"


def wrong_environment(path: Path, environment: Environment) -> Iterator[str]:
    """What is wrong with gravity, air and table."""
    x, y, z = environment.gravity_m_s2
    gravity = (x * x + y * y + z * z) ** 0.5
    if not 1.0 < gravity < 20.0:
        yield f"{path}: environment.gravity_m_s2 has length {gravity:.3g}; expected about 9.81 m/s^2"
    elif z > -0.7 * gravity:
        yield f"{path}: environment.gravity_m_s2 is {[x, y, z]}; z is up, so that it is about [0, 0, -9.81]"
    if environment.air_density_kg_m3 > 5.0:
        yield f"{path}: environment.air_density_kg_m3 is {environment.air_density_kg_m3}; air has about 1.2 kg/m^3"
    if (table := environment.table) is None:
        return
    if abs(table.height_m) > 10.0:
        yield f"{path}: environment.table.height_m is {table.height_m}; expected metres: are these millimetres?"
    if table.friction.value > 5.0:
        yield f"{path}: environment.table.friction is {table.friction.value}; cloth on a table has 0.1 to 1.5"
    if table.friction.std is not None and table.friction.log_std is not None:
        yield f"{path}: environment.table.friction has both std and log_std; keep one of them"


def wrong_holds(place: str, holds: list[HoldPart]) -> Iterator[str]:
    """What is wrong with the holds of one recording, as far as they say by themselves."""
    for hold in holds:
        if hold.to_s <= hold.from_s:
            yield f"{place}: a hold of drive {hold.drive!r} ends at {hold.to_s} s and starts at {hold.from_s} s"
        if len(set(hold.vertices)) != len(hold.vertices):
            yield f"{place}: a hold of drive {hold.drive!r} names a vertex twice: {hold.vertices}"
        if hold.places_m is None:
            continue
        if len(hold.places_m) != len(hold.vertices):
            yield f"{place}: a hold has {len(hold.places_m)} places_m for {len(hold.vertices)} vertices; give one each or null"
        far = max((abs(value) for row in hold.places_m for value in row), default=0.0)
        if far > FARTHEST_PLACE_M:
            yield f"{place}: places_m of drive {hold.drive!r} holds {far:.4g}; expected metres from the drive's frame, at most {FARTHEST_PLACE_M}"
    for first, one in enumerate(holds):
        for other in holds[first + 1 :]:
            both = sorted(set(one.vertices) & set(other.vertices))
            if both and one.from_s < other.to_s and other.from_s < one.to_s:
                yield f"{place}: vertices {both} are held twice at the same time ({one.drive!r}, {other.drive!r})"
