"""`bundle.yaml`: everything of a recording bundle that is not a time series, checked strictly."""

import re
from pathlib import Path
from typing import Annotated, Literal

import pydantic
import yaml

from sim1.stage import BadInput

SCHEMA = "sim1.recordings/1"

type Vector = tuple[float, float, float]
type Name = Annotated[str, pydantic.Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")]


class _Strict(pydantic.BaseModel):
    model_config = pydantic.ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Prior(_Strict):
    """A value and how sure one is of it: `std` in the same unit, or `log_std` of its natural logarithm."""

    value: pydantic.PositiveFloat
    std: pydantic.PositiveFloat | None = None
    log_std: pydantic.PositiveFloat | None = None


class Priors(_Strict):
    """What a data sheet or a kitchen scale says of the fabric, SI units."""

    area_density_kg_m2: Prior
    thickness_m: Prior
    stretch_n_m: Prior
    poisson: Prior
    bending_n_m: Prior
    damping_s: Prior


class GarmentPart(_Strict):
    """The recorded cloth: its mesh file and priors."""

    mesh: str
    prior: Priors


class Friction(_Strict):
    """Friction coefficient, which may be 0."""

    value: pydantic.NonNegativeFloat
    std: pydantic.PositiveFloat | None = None
    log_std: pydantic.PositiveFloat | None = None


class Table(_Strict):
    """A horizontal table top."""

    height_m: float
    friction: Friction


class Environment(_Strict):
    """Gravity, air and table."""

    gravity_m_s2: Vector
    air_density_kg_m3: pydantic.NonNegativeFloat
    table: Table | None


class MarkersPart(_Strict):
    """Noise of the markers, standard deviation per coordinate; null where nobody knows it."""

    noise_std_m: pydantic.PositiveFloat | None


class HoldPart(_Strict):
    """Vertices that move rigidly with a drive from `from_s` to `to_s`."""

    drive: str
    vertices: Annotated[list[pydantic.NonNegativeInt], pydantic.Field(min_length=1)]
    from_s: float
    to_s: float
    places_m: list[Vector] | None = None  # in the drive's frame; null: not measured


class RecordingPart(_Strict):
    """One recorded motion."""

    name: Name  # also the folder's name
    starts: Literal["rest", "moving"]
    holds: list[HoldPart]


class Document(_Strict):
    """Contents of `bundle.yaml`."""

    schema_: Literal["sim1.recordings/1"] = pydantic.Field(alias="schema")
    garment: GarmentPart
    environment: Environment
    markers: MarkersPart
    recordings: Annotated[list[RecordingPart], pydantic.Field(min_length=1)]


def read_document(path: Path) -> Document:
    """Read and check `bundle.yaml`.

    Raises:
        BadInput: missing, not YAML, an unknown or missing key, a value out of range; names the key.
    """
    try:
        raw = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise BadInput(f"{path}: missing; a bundle needs bundle.yaml, schema {SCHEMA}") from error
    except (yaml.YAMLError, UnicodeDecodeError, OSError) as error:
        raise BadInput(f"{path}: not readable as YAML ({' '.join(str(error).split())})") from error
    try:
        document = Document.model_validate(raw)
    except pydantic.ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "top"
        raise BadInput(f"{path}: {place}: {first['msg']} (got {first['input']!r}); see schema {SCHEMA}") from error
    _check(path, document)
    return document


def write_document(path: Path, document: Document) -> None:
    """Write `bundle.yaml`, keys in the order of the schema."""
    text = yaml.safe_dump(
        document.model_dump(by_alias=True, mode="json"), sort_keys=False, default_flow_style=None, width=120
    )
    path.write_text(text)


def _check(path: Path, document: Document) -> None:
    names = [recording.name for recording in document.recordings]
    if len(set(names)) != len(names):
        raise BadInput(f"{path}: recordings: a name occurs twice in {names}; every recording needs its own")
    if not re.fullmatch(r"[\w.-]+", document.garment.mesh) or document.garment.mesh.startswith("."):
        raise BadInput(f"{path}: garment.mesh is {document.garment.mesh!r}; name a file inside the bundle")
    gravity = sum(value**2 for value in document.environment.gravity_m_s2) ** 0.5
    if not 1.0 < gravity < 20.0:
        raise BadInput(f"{path}: environment.gravity_m_s2 has length {gravity:.3g}; expected about 9.81 m/s^2")
    prior = document.garment.prior
    for key, most in (("area_density_kg_m2", 5.0), ("thickness_m", 0.05), ("poisson", 0.5)):
        if getattr(prior, key).value > most:
            raise BadInput(
                f"{path}: garment.prior.{key} is {getattr(prior, key).value}; expected at most {most}, in SI units"
            )
    for recording in document.recordings:
        place = f"{path}: recording {recording.name}"
        for hold in recording.holds:
            if hold.to_s <= hold.from_s:
                raise BadInput(
                    f"{place}: a hold of drive {hold.drive!r} ends at {hold.to_s} s and starts at {hold.from_s} s"
                )
            if len(set(hold.vertices)) != len(hold.vertices):
                raise BadInput(f"{place}: a hold of drive {hold.drive!r} names a vertex twice: {hold.vertices}")
            if hold.places_m is not None and len(hold.places_m) != len(hold.vertices):
                raise BadInput(
                    f"{place}: a hold has {len(hold.places_m)} places_m for {len(hold.vertices)} vertices; give one each or null"
                )
        for first, one in enumerate(recording.holds):
            for other in recording.holds[first + 1 :]:
                both = set(one.vertices) & set(other.vertices)
                if both and one.from_s < other.to_s and other.from_s < one.to_s:
                    raise BadInput(
                        f"{place}: vertices {sorted(both)} are held twice at the same time ({one.drive!r}, {other.drive!r})"
                    )
