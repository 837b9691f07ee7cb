"""A seam or patch bends less."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class StiffRegion(Effect):
    """Bending rigidity times factor inside a disc."""

    name: ClassVar[str] = "stiff_region"
    signature: ClassVar[str] = "one place stays flat where the rest folds"
    source: ClassVar[str] = "local change of the plate rigidity"
    typical: ClassVar[str] = "2 to 50 times over 2 to 10 cm"
    varied: ClassVar[str] = (
        "held by the opposite edge, at two speeds (a stiff place goes with the cloth, and shows where it folds)"
    )
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="factor", unit="1", scale=1.5, kind="log", centre=1.0, low=0.05, high=200.0),
        Coefficient(name="centre_u", unit="m", scale=0.03, shape=True),
        Coefficient(name="centre_v", unit="m", scale=0.03, shape=True),
        Coefficient(name="radius", unit="m", scale=0.4, kind="log", centre=0.05, low=0.01, high=0.3, shape=True),
    )

    centre_u: float  # m
    centre_v: float  # m
    radius: float  # m
    factor: float  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, stiff_patch=(values["centre_u"], values["centre_v"], values["radius"], values["factor"]))

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Discs on a 4 x 4 grid over the sheet."""
        return [{"centre_u": u, "centre_v": v, "radius": 0.2 * site.width_m} for u, v in site.grid(4)]
