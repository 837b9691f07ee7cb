"""Warp and weft differ in bending."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from sim1.cloth.avbd.threads import across_of
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

    def shape(self, solver: Any) -> None:
        """Hinges get the rigidity of their direction; what that leaves of the tensor acts in `push`."""
        curving = solver.curves(self.name, tensors=1)
        across = across_of(solver.sheet.hinge.numpy(), solver.model.particle_q.numpy()) ** 2
        root = self.ratio_warp_weft**0.5
        factor = root * across[:, 0] ** 2 + across[:, 1] ** 2 / root + 2.0 * across[:, 0] * across[:, 1]
        curving.stiffen(solver.sheet, self.name, (factor - 1.0) * curving.rigidity.numpy())

    def push(self, solver: Any, dt: float) -> None:
        """What both directions resist more or less than the isotropic plate."""
        del dt
        (moment,) = solver.memory[self.name]
        root = self.ratio_warp_weft**0.5
        wp.launch(
            differ,
            dim=len(moment),
            inputs=[solver.curving.curvature, root - 1.0, 1.0 / root - 1.0, moment],
            device=moment.device,
        )
        solver.curving.answer(solver.sheet, solver.now, self.name, moment, solver.curving.rigidity)


@wp.kernel(enable_backward=False)
def differ(curvature: wp.array(dtype=wp.vec3), along: float, across: float, moment: wp.array(dtype=wp.vec3)):
    """Moment over rigidity that an orthotropic plate has beyond an isotropic one."""
    v = wp.tid()
    moment[v] = wp.vec3(along * curvature[v][0], across * curvature[v][1], 0.0)
