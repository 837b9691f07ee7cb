"""The stretch modulus grows with strain."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from sim1.cloth.avbd.threads import align
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class StrainStiffening(Effect):
    """Stress along each yarn is that of the strain e (1 + growth e) where it is pulled; shear and compression stay as they are."""

    name: ClassVar[str] = "strain_stiffening"
    signature: ClassVar[str] = "stretches less than in proportion to the load"
    source: ClassVar[str] = "exponent of woven fabrics at first order (Clyde et al. 2017)"
    typical: ClassVar[str] = "10 to 500"
    varied: ClassVar[str] = "pulled half as hard and twice as hard (strain then no longer follows the load)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (Coefficient(name="growth", unit="1", scale=60.0, low=0.0),)

    growth: float  # 1, relative growth of the modulus per strain

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, stiffening=values["growth"])

    def shape(self, solver: Any) -> None:
        """Let the modulus along warp and weft grow; see `sim1.cloth.avbd.elastic.membrane`."""
        align(solver.sheet, solver.model.particle_q.numpy(), solver.warp)
        solver.sheet.growth = self.growth
