"""What plays reality where there is no real cloth: a fabric that the stand-in lab films and the final trials meet, and no other stage sees."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from sim1.cloth.physics import ClothPhysics, Property, nominal_from_priors, write_physics
from sim1.cloth.precise.world import World
from sim1.recording.document import Priors
from sim1.recording.lab import AIR_DENSITY_KG_M3, FABRIC, GRAVITY, draw_world
from sim1.scan.garment_file import GarmentFile
from sim1.stage import BadInput, random_stream

SCHEMA = "sim1.reality/1"
FILE = "reality.json"


def priors_of(garment: GarmentFile) -> Priors:
    """What a garment file knows of its fabric."""
    return Priors.model_validate({name: vars(getattr(garment.fabric, name)) for name in Priors.model_fields})


def write_stand_in(
    out: Path, file: GarmentFile, garment: str, seed: int, air_probability: float, friction_log_std: float
) -> ClothPhysics:
    """Draw a fabric around the priors, air and friction; write `reality.json` and `cell.yaml`.

    Args:
        out: folder.
        file: the garment's.
        garment: its name.
        seed: of the draw.
        air_probability: that it moves in still air, which the baseline lacks.
        friction_log_std: spread of friction about what simulations assume.
    """
    world = draw_world(priors_of(file), air_probability, random_stream(seed, garment, "fabric"))
    values = {name: getattr(world, name) for name in (*FABRIC, "air_normal")}
    about = {"schema": SCHEMA, "virtual": True, "world": values}
    (out / FILE).write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")
    physics = _in_the_cell(file, world, friction_log_std, random_stream(seed, garment, "friction"))
    write_physics(out / "cell.yaml", physics)
    return physics


def _in_the_cell(file: GarmentFile, world: World, friction_log_std: float, stream: np.random.Generator) -> ClothPhysics:
    """The same fabric for the robot's cell, where it also touches things."""
    fabric = {name: vars(getattr(file.fabric, name)) for name in (*FABRIC, "thickness_m")}
    physics = nominal_from_priors(fabric).with_values(**{name: getattr(world, name) for name in FABRIC})
    contacts = {
        name: Property(value=float(getattr(physics.friction, name).value * np.exp(friction_log_std * off)))
        for name, off in zip(("table", "robot", "self"), np.clip(stream.standard_normal(3), -2, 2), strict=True)
    }
    drag = {"name": "air_drag", "parameters": {"c_normal": {"value": world.air_normal, "ci95": None, "unit": "1"}}}
    effects = (drag,) if world.air_normal else ()
    return replace(physics, friction=replace(physics.friction, **contacts), effects=effects)


def write_real(out: Path) -> None:
    """There are recordings of real cloth: nothing is drawn."""
    (out / FILE).write_text(json.dumps({"schema": SCHEMA, "virtual": False}, indent=1, sort_keys=True) + "\n")


def read_world(artifact: Path) -> World | None:
    """The stand-in lab's world, or None where reality is real.

    Raises:
        BadInput: missing, damaged, or of another schema.
    """
    path = artifact / FILE
    try:
        about = json.loads(path.read_text())
        if about["schema"] != SCHEMA:
            raise ValueError(f"schema is {about['schema']!r}, expected {SCHEMA!r}")
        if not about["virtual"]:
            return None
        return World(**about["world"], gravity_m_s2=GRAVITY, air_density_kg_m3=AIR_DENSITY_KG_M3)
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{path}: not readable ({error}); make reality again") from error
