"""The part of a fabric's model that the simulated cell can act: `cell.yaml` beside `model.yaml`."""

from dataclasses import replace

from sim1.cloth.effects import acts, effects_of
from sim1.cloth.physics import ClothPhysics


def cell_physics(physics: ClothPhysics) -> ClothPhysics:
    """The same fabric with the effects that `SolverAVBD` acts alone.

    Effects of the laboratory's rig and cameras are in neither: they are no part of a cell, and its mesh is its own.

    Raises:
        BadInput: an effect that the library does not know, or one with parameters that are not allowed.
    """
    effects = effects_of(physics.effects)
    kept = tuple(
        entry
        for entry, effect in zip(physics.effects, effects, strict=True)
        if acts(type(effect)) and not effect.measured
    )
    return replace(physics, effects=kept, mesh={}, mesh_refined=None)


def effects_left_out(model: ClothPhysics, cell: ClothPhysics) -> tuple[str, ...]:
    """Names of the cloth's effects in `model` that `cell` does without; those of rig and cameras are no part of a cell.

    Raises:
        BadInput: as `cell_physics`.
    """
    kept = {entry["name"] for entry in cell.effects}
    return tuple(effect.name for effect in effects_of(model.effects) if not effect.measured and effect.name not in kept)
