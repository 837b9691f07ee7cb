"""Physics that what plays reality has and a calibrated baseline lacks: which effects, how strong, drawn by chance."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim1.cloth.effects import EFFECTS, Effect
from sim1.stage import BadInput

# Each drawn evenly by its logarithm, within what is met (`Effect.typical`), away from where an effect is absent.
RANGES: dict[str, dict[str, tuple[tuple[float, float], ...]]] = {
    "air_drag": {"c_normal": ((1.1, 2.0),)},
    "anisotropic_bending": {"ratio_warp_weft": ((0.4, 0.6), (1.7, 2.5))},
    "anisotropic_stretch": {"ratio_warp_weft": ((0.4, 0.6), (1.7, 2.5))},
    "bending_hysteresis": {"moment": ((5e-5, 2e-4),), "slip_curvature": ((2.0, 6.0),)},
    "anisotropic_friction": {"ratio": ((0.5, 0.7), (1.4, 2.0))},
    "static_friction": {"ratio": ((1.3, 1.8),), "stribeck_speed": ((0.01, 0.03),)},
}
TOUCHING = frozenset(
    ("anisotropic_friction", "static_friction")
)  # on what the cloth lies: nothing that hangs free shows it


def draw_effects(chances: Mapping[str, float], friction: float, stream: np.random.Generator) -> tuple[Effect, ...]:
    """Each effect with its own chance, in the order of `RANGES`, whatever the others do.

    Args:
        chances: by name; what is not among them is never there.
        friction: coefficient of the table, of which an uneven one is the geometric mean.
        stream: of random numbers; as many are drawn whether an effect is there or not.

    Raises:
        BadInput: a name that is not among `RANGES`, or a chance that is none.
    """
    if unknown := sorted(set(chances) - set(RANGES)):
        raise BadInput(
            f"reality config: effects {unknown} are not among what may be concealed; choose from {sorted(RANGES)}"
        )
    if wrong := {name: share for name, share in chances.items() if not 0.0 <= share <= 1.0}:
        raise BadInput(f"reality config: effects {wrong}: a probability lies between 0 and 1")
    found = []
    for name, ranges in RANGES.items():
        there = stream.random() < chances.get(name, 0.0)
        values = {parameter: _drawn(choices, stream) for parameter, choices in ranges.items()}
        if there:
            found.append(_made(name, values, friction))
    return tuple(found)


def entry_of(effect: Effect) -> dict[str, Any]:
    """An effect as model files hold it; nothing was measured, so that there are no intervals."""
    values = {name: getattr(effect, name) for name in _given(effect)}
    units = type(effect).units() | type(effect).fixed
    return {
        "name": effect.name,
        "parameters": {name: {"value": value, "ci95": None, "unit": units[name]} for name, value in values.items()},
    }


def _given(effect: Effect) -> tuple[str, ...]:
    """Parameters that were drawn, or follow from what was."""
    return ("mu_x", "mu_y") if effect.name == "anisotropic_friction" else tuple(RANGES[effect.name])


def _drawn(choices: tuple[tuple[float, float], ...], stream: np.random.Generator) -> float:
    """A number from one of some ranges."""
    low, high = choices[int(stream.integers(len(choices)))]
    return float(np.exp(stream.uniform(np.log(low), np.log(high))))


def _made(name: str, values: dict[str, float], friction: float) -> Effect:
    if name == "anisotropic_friction":
        root = float(np.sqrt(values["ratio"]))
        values = {"mu_x": friction * root, "mu_y": friction / root}
    return EFFECTS[name](**values)
