"""Sticking friction above sliding friction."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class StaticFriction(Effect):
    """mu(v) = mu (1 + (ratio - 1) exp(-(v / 1 cm/s)^2))."""

    name: ClassVar[str] = "static_friction"
    signature: ClassVar[str] = "sticks to the table at first and then slides all at once"
    source: ClassVar[str] = "Stribeck 1902"
    typical: ClassVar[str] = "1.1 to 2"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="ratio", unit="1", scale=0.4, centre=1.0, low=1.0),
    )

    ratio: float  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, stiction=values["ratio"])

    on_table: ClassVar[bool] = True
