"""The cloth clings to the table."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class Adhesion(Effect):
    """Attraction `pressure` per area in contact, gone over a gap of 0.5 mm."""

    name: ClassVar[str] = "adhesion"
    signature: ClassVar[str] = "lifts late from the table, and needs more force to slide than its weight explains"
    source: ClassVar[str] = "pull-off pressure of textiles on smooth tables"
    typical: ClassVar[str] = "0.1 to 5 Pa"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (Coefficient(name="pressure", unit="Pa", scale=1.0, low=0.0),)

    pressure: float  # Pa

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, adhesion_pa=values["pressure"])

    on_table: ClassVar[bool] = True
