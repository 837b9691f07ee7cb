"""What plays reality where there is no real cloth: a fabric that the stand-in lab films and the final trials meet, and no other stage sees."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from sim1.cloth.effects import effects_of
from sim1.cloth.physics import ClothPhysics, Property, nominal_from_priors, write_physics
from sim1.cloth.precise.world import World
from sim1.recording.concealed import TOUCHING, draw_effects, entry_of
from sim1.recording.document import Priors
from sim1.recording.lab import AIR_DENSITY_KG_M3, FABRIC, GRAVITY, draw_fabric
from sim1.scan.garment_file import GarmentFile
from sim1.stage import BadInput, random_stream

SCHEMA = "sim1.reality/2"
FILE = "reality.json"


def priors_of(garment: GarmentFile) -> Priors:
    """What a garment file knows of its fabric."""
    return Priors.model_validate({name: vars(getattr(garment.fabric, name)) for name in Priors.model_fields})


def write_stand_in(
    out: Path,
    file: GarmentFile,
    garment: str,
    seed: int,
    chances: Mapping[str, float],
    friction_log_off: tuple[float, float],
) -> ClothPhysics:
    """Draw a fabric around the priors, effects and friction; write `reality.json` and `cell.yaml`.

    Args:
        out: folder.
        file: the garment's.
        garment: its name.
        seed: of the draw.
        chances: of effects that the baseline lacks, see `draw_effects`.
        friction_log_off: least and most by which the logarithm of each friction is off what simulations assume, either way.

    Raises:
        BadInput: an effect that cannot be concealed.
    """
    fabric = draw_fabric(priors_of(file), random_stream(seed, garment, "fabric"))
    cell = _cell(file, fabric, friction_log_off, random_stream(seed, garment, "friction"))
    effects = draw_effects(chances, cell.friction.table.value, random_stream(seed, garment, "effects"))
    entries = [entry_of(effect) for effect in effects]
    about = {
        "schema": SCHEMA,
        "virtual": True,
        "fabric": {name: getattr(fabric, name) for name in FABRIC},
        "effects": entries,
    }
    (out / FILE).write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")
    physics = replace(cell, effects=tuple(entries))
    write_physics(out / "cell.yaml", physics)
    return physics


def _cell(
    file: GarmentFile, world: World, friction_log_off: tuple[float, float], stream: np.random.Generator
) -> ClothPhysics:
    """The same fabric for the robot's cell, where it also touches things: with friction that no simulation assumes."""
    fabric = {name: vars(getattr(file.fabric, name)) for name in (*FABRIC, "thickness_m")}
    physics = nominal_from_priors(fabric).with_values(**{name: getattr(world, name) for name in FABRIC})
    names = ("table", "robot", "self")
    off = stream.uniform(*friction_log_off, size=3) * stream.choice([-1.0, 1.0], size=3)
    contacts = {
        name: Property(value=float(getattr(physics.friction, name).value * np.exp(one)))
        for name, one in zip(names, off, strict=True)
    }
    return replace(physics, friction=replace(physics.friction, **contacts))


def write_real(out: Path) -> None:
    """There are recordings of real cloth: nothing is drawn."""
    (out / FILE).write_text(json.dumps({"schema": SCHEMA, "virtual": False}, indent=1, sort_keys=True) + "\n")


def read_world(artifact: Path) -> World | None:
    """The stand-in lab's world, or None where reality is real; what acts on what the cloth lies on is not in it, as nothing lies there.

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
        world = World(**about["fabric"], gravity_m_s2=GRAVITY, air_density_kg_m3=AIR_DENSITY_KG_M3)
        for effect in effects_of(tuple(about["effects"])):
            world = world if effect.name in TOUCHING else effect.act(world)
        return world
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{path}: not readable ({error}); make reality again") from error
