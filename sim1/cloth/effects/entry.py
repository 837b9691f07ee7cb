"""An effect from its entry in a model file."""

from dataclasses import MISSING, fields
from typing import Any

from sim1.cloth.effects.effect import Effect
from sim1.stage import BadInput


def effect_of(entry: dict[str, Any], known: dict[str, type[Effect]], place: str) -> Effect:
    """One `{name, parameters: {p: {value, ci95, unit}}}` entry as an effect; `place` begins the message of an error.

    Code may leave a unit out, a model file may not (`physics_document.py`).

    Raises:
        BadInput: unknown name or parameter, missing parameter, another unit, or a value that is not allowed.
    """
    name = entry.get("name")
    if name not in known:
        raise BadInput(f"{place}: {name!r} is not an effect that the simulation knows; known: {sorted(known)}")
    kind, given = known[name], entry.get("parameters") or {}
    units = kind.units() | kind.fixed
    if unknown := sorted(set(given) - set(units)):
        raise BadInput(f"{place}: {name} has unknown parameters {unknown}, allowed: {sorted(units)}")
    needed = {field.name for field in fields(kind) if field.default is MISSING}
    if lacking := sorted(needed - set(given)):
        raise BadInput(f"{place}: {name} lacks the parameters {lacking}; give it {sorted(needed)}")
    directions = {field.name for field in fields(kind) if isinstance(field.default, tuple)}
    for key, item in given.items():
        value, unit = item["value"], item.get("unit", units[key])
        if isinstance(value, list | tuple) != (key in directions):
            shape = "three numbers" if key in directions else "one number"
            raise BadInput(f"{place}: {name}: {key} is {value}, expected {shape} in {units[key]}")
        if unit != units[key]:
            raise BadInput(
                f"{place}: {name}: {key} is {value} {unit}, expected in {units[key]}; give value and ci95 in that unit"
            )
    try:
        return kind(**{key: item["value"] for key, item in given.items()})
    except ValueError as error:
        raise BadInput(f"{place}: {error}") from error
