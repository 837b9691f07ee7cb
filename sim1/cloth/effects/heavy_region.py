"""A wet patch, a button, a trim."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class HeavyRegion(Effect):
    """Extra mass around a place, as a bell of 15 mm."""

    name: ClassVar[str] = "heavy_region"
    signature: ClassVar[str] = "one place hangs lower and swings later than the rest"
    source: ClassVar[str] = "lumped mass"
    typical: ClassVar[str] = "1 to 30 g"
    varied: ClassVar[str] = "held by the opposite edge, at rest too (a weight goes with the cloth, and hangs lower)"
    testing: ClassVar[str | None] = (
        "weigh the cloth, and film the same motion again an hour later: water dries, a weight stays"
    )
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="mass", unit="kg", scale=0.004, low=0.0),
        Coefficient(name="centre_u", unit="m", scale=0.03, shape=True),
        Coefficient(name="centre_v", unit="m", scale=0.03, shape=True),
    )

    centre_u: float  # m
    centre_v: float  # m
    mass: float  # kg

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, heavy_patch=(values["centre_u"], values["centre_v"], values["mass"]))

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Places on a 4 x 4 grid over the sheet."""
        return [{"centre_u": u, "centre_v": v} for u, v in site.grid(4)]
