"""Physics beyond the plain cloth model: one file per effect, registered by its name in `model.yaml`.

An effect is a frozen dataclass of its parameters (SI units). It may change the cloth's arrays once (`shape`) and add forces in
every step (`push`). Adding an effect is adding a file and a line in `EFFECTS`.
"""

from sim1.cloth.effects.air_drag import AirDrag
from sim1.cloth.effects.anisotropic_stretch import AnisotropicStretch
from sim1.cloth.effects.effect import Effect, effect_of

EFFECTS: dict[str, type[Effect]] = {effect.name: effect for effect in (AirDrag, AnisotropicStretch)}

__all__ = ["EFFECTS", "AirDrag", "AnisotropicStretch", "Effect", "effect_of", "effects_of"]


def effects_of(entries: tuple[dict, ...]) -> tuple[Effect, ...]:
    """Effects of a model file's `effects` entries (`sim1.model/1`).

    Raises:
        BadInput: unknown name or parameter, or a value that is not allowed.
    """
    return tuple(effect_of(entry, EFFECTS) for entry in entries)
