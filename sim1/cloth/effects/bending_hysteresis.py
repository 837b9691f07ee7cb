"""Rate-independent internal friction in bending."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

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
    varied: ClassVar[str] = "at half the pace (friction in the yarns loses the same in every cycle, however slow)"
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

    def shape(self, solver: Any) -> None:
        """Memory: curvature as it was, and as the friction feels it; hinges get the stiffness of friction that sticks."""
        curving = solver.curves(self.name, tensors=2)
        curving.stiffen(solver.sheet, self.name, self.moment / self.slip_curvature * curving.firmness)

    def push(self, solver: Any, dt: float) -> None:
        """Friction as the step begins; within the step it sticks."""
        del dt
        before, felt = solver.memory[self.name]
        curving = solver.curving
        wp.launch(
            rub,
            dim=len(before),
            inputs=[curving.curvature, before, felt, self.slip_curvature],
            device=before.device,
        )
        extra = curving.extra[self.name]
        curving.answer(solver.sheet, felt, extra, extra, curving.angle)

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Slipping within a slight change of curvature, and within a large one."""
        del site
        return [{"slip_curvature": start} for start in (1.5, 5.0, 15.0)]


@wp.kernel(enable_backward=False)
def rub(
    curvature: wp.array(dtype=wp.vec3),
    before: wp.array(dtype=wp.vec3),
    felt: wp.array(dtype=wp.vec3),
    slip_curvature: float,
):
    """Dahl's z times the slip curvature, carried over a step, for each part of the curvature."""
    v = wp.tid()
    for k in range(3):
        change = curvature[v][k] - before[v][k]
        felt[v][k] = (felt[v][k] + change) / (1.0 + wp.abs(change) / slip_curvature)
    before[v] = curvature[v]
