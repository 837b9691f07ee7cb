"""Physics beyond the plain cloth model: one file per effect, registered by its name in `model.yaml`.

An effect is a frozen dataclass of its parameters (SI units). Adding one is adding a file and a line here.
"""

from sim1.cloth.effects.actuator_lag import ActuatorLag
from sim1.cloth.effects.added_mass import AddedMass
from sim1.cloth.effects.adhesion import Adhesion
from sim1.cloth.effects.air_drag import AirDrag
from sim1.cloth.effects.anisotropic_bending import AnisotropicBending
from sim1.cloth.effects.anisotropic_friction import AnisotropicFriction
from sim1.cloth.effects.anisotropic_stretch import AnisotropicStretch
from sim1.cloth.effects.bending_hysteresis import BendingHysteresis
from sim1.cloth.effects.clock_offset import ClockOffset
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.effects.entry import effect_of
from sim1.cloth.effects.frame_offset import FrameOffset
from sim1.cloth.effects.gravity_tilt import GravityTilt
from sim1.cloth.effects.grip_compliance import GripCompliance
from sim1.cloth.effects.grip_slip import GripSlip
from sim1.cloth.effects.heavy_region import HeavyRegion
from sim1.cloth.effects.plastic_crease import PlasticCrease
from sim1.cloth.effects.rest_curvature import RestCurvature
from sim1.cloth.effects.shrinkage import Shrinkage
from sim1.cloth.effects.static_friction import StaticFriction
from sim1.cloth.effects.stiff_region import StiffRegion
from sim1.cloth.effects.strain_stiffening import StrainStiffening
from sim1.cloth.effects.wind import Wind
from sim1.stage import BadInput

EFFECTS: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        ActuatorLag,
        AddedMass,
        Adhesion,
        AirDrag,
        AnisotropicBending,
        AnisotropicFriction,
        AnisotropicStretch,
        BendingHysteresis,
        ClockOffset,
        FrameOffset,
        GravityTilt,
        GripCompliance,
        GripSlip,
        HeavyRegion,
        PlasticCrease,
        RestCurvature,
        Shrinkage,
        StaticFriction,
        StiffRegion,
        StrainStiffening,
        Wind,
    )
}

__all__ = [
    "EFFECTS",
    "ActuatorLag",
    "AddedMass",
    "Adhesion",
    "AirDrag",
    "AnisotropicBending",
    "AnisotropicFriction",
    "AnisotropicStretch",
    "BendingHysteresis",
    "ClockOffset",
    "Effect",
    "FrameOffset",
    "GravityTilt",
    "GripCompliance",
    "GripSlip",
    "HeavyRegion",
    "PlasticCrease",
    "RestCurvature",
    "Shrinkage",
    "Site",
    "StaticFriction",
    "StiffRegion",
    "StrainStiffening",
    "Wind",
    "acted_effects",
    "acts",
    "effect_of",
    "effects_of",
]


def effects_of(entries: tuple[dict, ...], place: str = "effects") -> tuple[Effect, ...]:
    """Effects of a model file's `effects` entries (`sim1.model/1`); `place` begins the message of an error.

    Raises:
        BadInput: an effect twice, unknown name or parameter, missing parameter, another unit, or a value that is not allowed.
    """
    effects = tuple(effect_of(entry, EFFECTS, place) for entry in entries)
    names = [effect.name for effect in effects]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise BadInput(f"{place}: {', '.join(twice)} more than once; name each effect once")
    return effects


def acts(effect: type[Effect]) -> bool:
    """Whether `SolverAVBD` acts an effect."""
    return effect.shape is not Effect.shape or effect.push is not Effect.push


def acted_effects(entries: tuple[dict, ...]) -> tuple[Effect, ...]:
    """Effects of a model file that `SolverAVBD` acts; those of rig and cameras are left to the laboratory.

    Raises:
        BadInput: as `effects_of`, or physics of the cloth that the solver cannot act: leaving it out silently would be a lie.
    """
    effects = effects_of(entries)
    for effect in effects:
        if not effect.measured and not acts(type(effect)):
            able = sorted(name for name, known in EFFECTS.items() if acts(known))
            raise BadInput(
                f"effects: {effect.name!r} is known to the identification simulator alone, the cloth solver acts {able}; "
                "simulate with cell.yaml, which does without it and says so, or with baseline.yaml"
            )
    return tuple(effect for effect in effects if not effect.measured)
