"""The rest size differs from the scan."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from sim1.cloth.avbd.threads import align, resized, stretched
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class Shrinkage(Effect):
    """True rest size = scale x scanned size along u and v, mass unchanged."""

    name: ClassVar[str] = "shrinkage"
    signature: ClassVar[str] = "distances along the cloth are off by a constant share, loaded or not"
    source: ClassVar[str] = "growth of the rest metric"
    typical: ClassVar[str] = "0.93 to 1.05"
    varied: ClassVar[str] = "the cloth hung still beside a ruler (lengths are off by one share, loaded or not)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="scale_u", unit="1", scale=0.015, kind="log", centre=1.0, low=0.7, high=1.3),
        Coefficient(name="scale_v", unit="1", scale=0.015, kind="log", centre=1.0, low=0.7, high=1.3),
    )

    scale_u: float  # 1
    scale_v: float  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, scale=(values["scale_u"], values["scale_v"]))

    def shape(self, solver: Any) -> None:
        """Another size at rest; what was scanned is strained by the difference."""
        factors = (self.scale_u, self.scale_v)
        align(solver.sheet, solver.model.particle_q.numpy(), solver.warp)
        resized(solver.sheet, factors)
        solver.hinge_corners_m = stretched(solver.hinge_corners_m, factors, solver.warp)

    rank: ClassVar[int] = 2  # what others make of the sheet, they make of it at its size at rest
