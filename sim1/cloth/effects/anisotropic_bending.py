"""Warp and weft differ in bending."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class AnisotropicBending(Effect):
    """B_u = B sqrt(r), B_v = B / sqrt(r), twist unchanged."""

    name: ClassVar[str] = "anisotropic_bending"
    signature: ClassVar[str] = "folds along one thread direction are wider than along the other"
    source: ClassVar[str] = "orthotropic plate (Kawabata bending test)"
    typical: ClassVar[str] = "0.4 to 4.6"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="ratio_warp_weft", unit="1", scale=0.7, kind="log", centre=1.0, low=0.02, high=50.0),
    )

    ratio_warp_weft: float  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, bending_ratio=values["ratio_warp_weft"])
