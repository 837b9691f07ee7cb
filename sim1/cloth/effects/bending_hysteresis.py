"""Rate-independent internal friction in bending."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class BendingHysteresis(Effect):
    """M = moment z, dz/dt = dkappa/dt / kappa_c - |dkappa/dt| / kappa_c z, with kappa_c = 5 1/m."""

    name: ClassVar[str] = "bending_hysteresis"
    signature: ClassVar[str] = (
        "loses the same energy in every bending cycle however slow, and rests where friction holds it"
    )
    source: ClassVar[str] = "Dahl 1968; Kawabata's 2HB is twice the moment"
    typical: ClassVar[str] = "1e-5 to 1e-3 N"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (Coefficient(name="moment", unit="N", scale=0.00015, low=0.0),)

    moment: float  # N, per width

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, hysteresis_n=values["moment"])
