"""Fold lines keep part of their angle."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
import warp as wp

from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.threads import hinge_width
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class PlasticCrease(Effect):
    """Curvature beyond the yield curvature is kept in part as rest curvature."""

    name: ClassVar[str] = "plastic_crease"
    signature: ClassVar[str] = "bent sharply once, the sheet stays bent at that line"
    source: ClassVar[str] = "elastoplastic hinge (Narain et al. 2013)"
    typical: ClassVar[str] = "yield at 10 to 200 1/m, 0.1 to 0.8 kept"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="retained", unit="1", scale=0.3, low=0.0, high=1.0),
        Coefficient(
            name="yield_curvature", unit="1/m", scale=0.5, kind="log", centre=20.0, low=0.5, high=1000.0, shape=True
        ),
    )

    yield_curvature: float  # 1/m
    retained: float  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, yield_1_m=values["yield_curvature"], retained=values["retained"])

    def shape(self, solver: Any) -> None:
        """Memory of the hinges: the width over which each turns [m], and the curvature that ever yielded there [1/m]."""
        width = hinge_width(solver.sheet.hinge.numpy(), solver.model.particle_q.numpy())
        solver.remember(self.name, np.stack([width, np.zeros_like(width)], axis=1))

    def push(self, solver: Any, dt: float) -> None:
        """What is beyond yield as the step begins becomes rest angle, in part."""
        del dt
        if self.retained == 0.0:
            return
        wp.launch(
            yield_hinges,
            dim=len(solver.sheet.hinge),
            inputs=[solver.sheet, solver.now, solver.memory[self.name], self.yield_curvature, self.retained],
            device=solver.model.device,
        )

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Yield curvatures below the largest that the recordings reach."""
        return [{"yield_curvature": share * site.curvature_1_m} for share in (0.25, 0.5, 0.75)]


@wp.kernel(enable_backward=False)
def yield_hinges(sheet: Sheet, now: Iterate, yielded: wp.array(dtype=wp.vec2), limit: float, retained: float):
    """Elastoplastic hinge; it hardens by what it ever yielded, whichever way, as `sim1.cloth.precise.memory.fold`."""
    h = wp.tid()
    width = yielded[h][0]
    elastic = (now.hinge_now[h] - sheet.hinge_angle[h]) / width
    beyond = wp.abs(elastic) - limit - (1.0 - retained) / retained * yielded[h][1]
    if beyond > 0.0:
        sheet.hinge_angle[h] = sheet.hinge_angle[h] + wp.sign(elastic) * retained * beyond * width
        yielded[h] = wp.vec2(width, yielded[h][1] + retained * beyond)
