"""The garment file `data/garments/G.yaml`: what a person knows about a garment before it is scanned."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Literal

import numpy as np
import pydantic
from pydantic.dataclasses import dataclass

from sim1.data_file import explained, read_yaml
from sim1.stage import BadInput

METRES_PER_UNIT = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}

type Axis = Literal["x", "y", "z", "-x", "-y", "-z"]
_strict = pydantic.ConfigDict(extra="forbid")


@dataclass(frozen=True, kw_only=True, config=_strict)
class Prior:
    """A fabric parameter and how sure one is of it: `std` in its own unit, `log_std` of its natural logarithm."""

    value: pydantic.PositiveFloat
    std: pydantic.NonNegativeFloat | None = None
    log_std: pydantic.NonNegativeFloat | None = None


@dataclass(frozen=True, kw_only=True, config=_strict)
class Fabric:
    """Priors of the fabric in SI units; the definitions are those of a recording bundle."""

    area_density_kg_m2: Prior
    thickness_m: Prior
    stretch_n_m: Prior  # isotropic membrane Young's modulus times thickness
    poisson: Prior
    bending_n_m: Prior  # plate rigidity
    damping_s: Prior  # Kelvin-Voigt time constant


@dataclass(frozen=True, kw_only=True, config=_strict)
class Frame:
    """Axes of the scan files: which one points up, and which one the front of the garment faces."""

    up: Axis = "z"
    front: Axis = "x"


@dataclass(frozen=True, kw_only=True, config=_strict)
class GarmentFile:
    """Contents of a garment file, schema `sim1.garment/1`."""

    schema: Literal["sim1.garment/1"]
    title: str
    units: Literal["m", "cm", "mm", "in"]
    virtual: bool = False  # made by a model of a scanner, not measured
    openings: pydantic.PositiveInt  # boundary loops of the real garment
    frame: Frame = Frame()
    fabric: Fabric

    @property
    def metres_per_unit(self) -> float:
        return METRES_PER_UNIT[self.units]


def read_garment_file(path: Path) -> GarmentFile:
    """Read and check a garment file.

    Raises:
        BadInput: not readable, not YAML, a key that is unknown, missing or there twice, a value out of range, axes that
            are not at right angles.
    """
    values = read_yaml(path, "docs/scan-format.md shows a garment file")
    if not isinstance(values, dict):
        raise BadInput(
            f"{path}: expected keys and values, got {type(values).__name__}; docs/scan-format.md shows a garment file"
        )
    try:
        garment = pydantic.TypeAdapter(GarmentFile).validate_python(values)
    except pydantic.ValidationError as error:
        raise BadInput(f"{path}: {explained(error)}") from error
    frame_rotation(garment.frame, path)
    return garment


def canonical_json(garment: GarmentFile) -> str:
    """The same bytes for the same meaning, whatever the comments and the order of keys."""
    return json.dumps(asdict(garment), indent=1, sort_keys=True) + "\n"


def frame_rotation(frame: Frame, path: Path | str = "garment file") -> np.ndarray:
    """Rotation (3, 3) from the scan's axes to the project's: front x, left y, up z.

    Raises:
        BadInput: up and front lie on the same axis.
    """
    up, front = _unit(frame.up), _unit(frame.front)
    if abs(up @ front) > 0.5:
        raise BadInput(f"{path}: frame: up is {frame.up} and front is {frame.front}; give two different axes")
    return np.stack([front, np.cross(up, front), up])


def _unit(axis: str) -> np.ndarray:
    return np.eye(3)["xyz".index(axis[-1])] * (-1.0 if axis.startswith("-") else 1.0)
