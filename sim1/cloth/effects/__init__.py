"""Physics beyond the plain cloth model: one file per effect, found by lying in this folder, registered by its name in `model.yaml`.

An effect is a frozen dataclass of its parameters (SI units). Adding one is adding a file.
"""

from collections.abc import Iterable
from importlib import import_module
from inspect import get_annotations
from pkgutil import iter_modules
from types import ModuleType

from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.effects.entry import effect_of
from sim1.stage import BadInput

__all__ = ["EFFECTS", "Effect", "Site", "acted_effects", "acts", "effect_of", "effects_in", "effects_of"]

NEEDED = (*(each for each in get_annotations(Effect) if not hasattr(Effect, each)), "alter")


def effects_in(package: str, folders: Iterable[str]) -> dict[str, type[Effect]]:
    """Every effect that a module of a package defines, by its name; `folders` are the package's.

    Raises:
        ValueError: an effect that lacks what a search or a report asks of it, or two of one name.
    """
    found: dict[str, type[Effect]] = {}
    for listed in iter_modules(folders):
        module = import_module(f"{package}.{listed.name}")
        for effect in _defined(module):
            own = {each for one in effect.__mro__[: effect.__mro__.index(Effect)] for each in vars(one)}
            if lacking := [each for each in NEEDED if each not in own]:
                raise ValueError(
                    f"{module.__file__}: {effect.__name__} lacks {', '.join(lacking)}; effect.py says what each means"
                )
            if effect.name in found:
                raise ValueError(
                    f"{module.__file__}: {effect.name} is the name of the effect in {found[effect.name].__module__}, too; give it its own"
                )
            found[effect.name] = effect
    return found


def _defined(module: ModuleType) -> list[type[Effect]]:
    classes = [value for value in vars(module).values() if isinstance(value, type) and issubclass(value, Effect)]
    return [one for one in classes if one.__module__ == module.__name__ and one is not Effect]


EFFECTS: dict[str, type[Effect]] = effects_in(__name__, __path__)


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
