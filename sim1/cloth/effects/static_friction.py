"""Sticking friction above sliding friction."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.touch import Touches, point_of
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class StaticFriction(Effect):
    """mu(v) = mu (1 + (ratio - 1) exp(-(v / stribeck_speed)^2))."""

    name: ClassVar[str] = "static_friction"
    signature: ClassVar[str] = "sticks to the table at first and then slides all at once"
    source: ClassVar[str] = "Stribeck 1902"
    typical: ClassVar[str] = "1.1 to 2"
    varied: ClassVar[str] = "with stops on the way (it sticks anew at every start)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="ratio", unit="1", scale=0.4, centre=1.0, low=1.0),
        Coefficient(
            name="stribeck_speed", unit="m/s", scale=0.7, kind="log", centre=0.01, low=0.001, high=0.3, shape=True
        ),
    )

    ratio: float  # 1
    stribeck_speed: float = 0.01  # m/s; sliding faster than this, nothing is left of it

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, stiction=values["ratio"], stribeck_m_s=values["stribeck_speed"])

    def push(self, solver: Any, dt: float) -> None:
        """Friction on the table by the speed at which each point is expected to slide."""
        del dt
        wp.launch(
            stick,
            dim=solver.solids.capacity,
            inputs=[solver.solids, solver.now, solver.table, self.ratio, self.stribeck_speed],
            device=solver.model.device,
        )

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Gone as soon as anything slides, and only well after."""
        del site
        return [{"stribeck_speed": start} for start in (0.006, 0.02, 0.06)]

    on_table: ClassVar[bool] = True


@wp.kernel(enable_backward=False)
def stick(solids: Touches, now: Iterate, table: int, ratio: float, stribeck_speed: float):
    """Multiply the friction of each contact with the table; the table stands still."""
    c = wp.tid()
    if solids.shape[c] == table and solids.vertex[c][0] >= 0:
        velocity = point_of(solids.vertex[c], solids.weight[c], now.expected)
        normal = solids.normal[c]
        slide = wp.length(velocity - wp.dot(velocity, normal) * normal) / stribeck_speed
        solids.friction[c] = solids.friction[c] * (1.0 + (ratio - 1.0) * wp.exp(-slide * slide))
