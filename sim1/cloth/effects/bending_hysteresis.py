"""Rate-independent internal friction in bending."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class BendingHysteresis(Effect):
    """M = moment z, dz/dt = dkappa/dt / kappa_c - |dkappa/dt| / kappa_c z, kappa_c = slip_curvature."""

    name: ClassVar[str] = "bending_hysteresis"
    signature: ClassVar[str] = (
        "loses the same energy in every bending cycle however slow, and rests where friction holds it"
    )
    source: ClassVar[str] = "Dahl 1968; Kawabata's 2HB is twice the moment"
    typical: ClassVar[str] = "1e-5 to 1e-3 N"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="moment", unit="N", scale=0.00015, low=0.0),
        Coefficient(
            name="slip_curvature", unit="1/m", scale=0.7, kind="log", centre=4.0, low=0.2, high=100.0, shape=True
        ),
    )

    moment: float  # N, per width
    slip_curvature: float = 4.0  # 1/m; change of curvature over which the moment turns round

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, hysteresis_n=values["moment"], turn_1_m=values["slip_curvature"])

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Slipping within a slight change of curvature, and within a large one."""
        del site
        return [{"slip_curvature": start} for start in (1.5, 5.0, 15.0)]
