"""How far off coefficients are, as a share of what was concealed: of how far the truth departs from where its effect is absent."""

import math
from collections.abc import Mapping

from sim1.cloth.effects import EFFECTS
from sim1.cloth.effects.coefficient import Coefficient
from sim1.proof.outcome import Number


def effect_errors(effect: str, numbers: Mapping[str, Number]) -> list[float]:
    """Of each coefficient whose truth is known, over the largest departure of those of its unit: a tilt about one axis is no worse found
    for being small.

    A ratio that is 1 where nothing is there departs by its logarithm. What says where or from when an effect acts is absent nowhere: it is
    held to its own value, by the logarithm too where it is searched so.
    """
    pairs = {name: (n.value, n.true) for name, n in numbers.items() if n.true is not None}
    if effect in EFFECTS and set(EFFECTS[effect].units()) <= set(pairs):
        searched = EFFECTS[effect].searched
        found, true = (searched({name: pair[side] for name, pair in pairs.items()}) for side in (0, 1))
        pairs = {name: (found[name], true[name]) for name in found}
    coefficients = {c.name: c for c in EFFECTS[effect].coefficients} if effect in EFFECTS else {}
    rows, largest = [], dict[str, float]()
    for name, pair in pairs.items():
        coefficient = coefficients.get(name)
        off, departs = _off(coefficient, *pair)
        unit = coefficient.unit if coefficient else numbers[name].unit
        group = name if coefficient and coefficient.shape and coefficient.kind == "log" else unit
        largest[group] = max(largest.get(group, 0.0), departs)
        rows.append((off, group))
    return [off / largest[group] for off, group in rows if largest[group] > 0.0]


def _off(coefficient: Coefficient | None, found: float, true: float) -> tuple[float, float]:
    """How far off, and how far the truth departs from nothing, on the scale of the coefficient."""
    if coefficient is None or (coefficient.shape and coefficient.kind == "linear"):
        return abs(found - true), abs(true)
    if coefficient.kind == "linear":
        return abs(found - true), abs(true - coefficient.centre)
    return abs(math.log(found / true)), 1.0 if coefficient.shape else abs(math.log(true / coefficient.centre))


def relative_error(number: Number) -> list[float]:
    """Of a parameter that is never absent, over its own value; none where that is not known, or nothing."""
    return [abs(number.value - number.true) / abs(number.true)] if number.true else []
