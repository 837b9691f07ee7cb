"""The part of a fabric's model that the simulated cell can act: `cell.yaml` beside `model.yaml`."""

from dataclasses import replace

from sim1.cloth.effects import acts, effects_of
from sim1.cloth.physics import ClothPhysics


def cell_physics(physics: ClothPhysics) -> tuple[ClothPhysics, tuple[str, ...]]:
    """The same fabric with the effects that `SolverAVBD` acts alone, and the names of the cloth's effects that it leaves out.

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
    left_out = tuple(effect.name for effect in effects if not acts(type(effect)) and not effect.measured)
    return replace(physics, effects=kept, mesh={}), left_out
