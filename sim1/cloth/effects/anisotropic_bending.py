"""Warp and weft differ in bending."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
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
    varied: ClassVar[str] = "held by the neighbouring edge (folds then run along the other threads)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="ratio_warp_weft", unit="1", scale=0.7, kind="log", centre=1.0, low=0.02, high=50.0),
    )

    ratio_warp_weft: float  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, bending_ratio=values["ratio_warp_weft"])

    def shape(self, solver: Any) -> None:
        """Hinges get about the stiffness of their direction and its damping; what that leaves of the tensor acts in `push`.

        The tensor's energy 1/2 kappa Q kappa becomes 1/2 kappa R Q R kappa, R = diag(r^(1/4), r^(-1/4), 1): positive for
        every ratio and mesh, and as Q otherwise, whatever coupling of warp and weft the hinges have.
        """
        curving, sheet = solver.curves(self.name, tensors=1), solver.sheet
        stiffness = curving.stiffness.numpy()
        turn = np.diag([self.ratio_warp_weft**0.25, self.ratio_warp_weft**-0.25, 1.0])
        change = turn @ curving.law @ turn - curving.law
        curving.turns[self.name] = wp.array((curving.ease @ change).astype(np.float32), dtype=wp.mat33)
        across = across_of(solver.hinge_corners_m, solver.warp) ** 2
        root = self.ratio_warp_weft**0.5
        factor = root * across[:, 0] ** 2 + across[:, 1] ** 2 / root + 2.0 * across[:, 0] * across[:, 1]
        curving.stiffen(sheet, self.name, np.maximum(factor * stiffness, curving.late(sheet, change)) - stiffness)
        sheet.hinge_damping.assign(
            sheet.hinge_damping.numpy() + curving.time.numpy() * curving.extra[self.name].numpy()
        )

    def push(self, solver: Any, dt: float) -> None:
        """What both directions resist more or less than the isotropic plate, of what folds have not kept."""
        del dt
        (felt,) = solver.memory[self.name]
        curving = solver.curving
        wp.launch(
            differ,
            dim=len(felt),
            inputs=[curving.damped_curvature, curving.kept, curving.turns[self.name], felt],
            device=felt.device,
        )
        curving.answer(solver.sheet, felt, curving.stiffness, curving.extra[self.name], curving.damped_angle)


@wp.kernel(enable_backward=False)
def differ(
    curvature: wp.array(dtype=wp.vec3),
    kept: wp.array(dtype=wp.vec3),
    turn: wp.array(dtype=wp.mat33),
    felt: wp.array(dtype=wp.vec3),
):
    """Curvature that an isotropic plate would resist as an orthotropic one does beyond it."""
    v = wp.tid()
    felt[v] = turn[v] * (curvature[v] - kept[v])
