"""Fold lines keep part of their angle."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

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
    varied: ClassVar[str] = "once more after the cloth was laid flat and smoothed (a fold line stays)"
    testing: ClassVar[str | None] = (
        "lay the cloth flat, and film the same motion again an hour later: a crease stays, creep comes back"
    )
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
        """Memory: curvature that is kept, all that ever yielded, and how the sheet resists what is kept."""
        curving = solver.curves(self.name, tensors=2)
        solver.memory[self.name].insert(0, curving.kept)

    def push(self, solver: Any, dt: float) -> None:
        """What is beyond yield as the step begins becomes curvature at rest, in part."""
        del dt
        kept, yielded, back = solver.memory[self.name]
        curving = solver.curving
        if self.retained > 0.0:
            wp.launch(
                fold,
                dim=len(kept),
                inputs=[curving.curvature, kept, yielded, back, self.yield_curvature, self.retained],
                device=kept.device,
            )
            curving.answer(solver.sheet, back, curving.stiffness, curving.none, curving.angle)

    beyond: ClassVar[bool] = True
    rank: ClassVar[int] = 1  # what folds keep, other physics of bending does not resist

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Yield curvatures below the largest that the recordings reach."""
        return [{"yield_curvature": share * site.curvature_1_m} for share in (0.25, 0.5, 0.75)]


@wp.kernel(enable_backward=False)
def fold(
    curvature: wp.array(dtype=wp.vec3),
    kept: wp.array(dtype=wp.vec3),
    yielded: wp.array(dtype=wp.vec3),
    back: wp.array(dtype=wp.vec3),
    limit: float,
    retained: float,
):
    """Each part of the curvature yields by itself and hardens by what it ever yielded, as `precise.memory.fold`."""
    v = wp.tid()
    for k in range(3):
        elastic = curvature[v][k] - kept[v][k]
        beyond = wp.abs(elastic) - limit - (1.0 - retained) / retained * yielded[v][k]
        if beyond > 0.0:
            kept[v][k] = kept[v][k] + wp.sign(elastic) * retained * beyond
            yielded[v][k] = yielded[v][k] + retained * beyond
    back[v] = -kept[v]
