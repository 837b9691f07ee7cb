"""The cloth clings to the table."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class Adhesion(Effect):
    """Attraction `pressure` per area in contact, gone over a gap of `reach`: peeling takes pressure times reach over two."""

    name: ClassVar[str] = "adhesion"
    signature: ClassVar[str] = "lifts late from the table, and needs more force to slide than its weight explains"
    source: ClassVar[str] = "pull-off pressure of textiles on smooth tables"
    typical: ClassVar[str] = "0.1 to 5 Pa"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="pressure", unit="Pa", scale=1.0, low=0.0),
        Coefficient(name="reach", unit="m", scale=0.7, kind="log", centre=5e-4, low=1e-4, high=1e-2, shape=True),
    )

    pressure: float  # Pa
    reach: float = 5e-4  # m

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, adhesion_pa=values["pressure"], cling_m=values["reach"])

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Clinging by contact alone, and by fibres or charges that reach farther."""
        del site
        return [{"reach": start} for start in (5e-4, 2e-3)]

    on_table: ClassVar[bool] = True
