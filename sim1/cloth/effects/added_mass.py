"""Air carried along by a moving sheet."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class AddedMass(Effect):
    """f = -m_a (n . a) n per area."""

    name: ClassVar[str] = "added_mass"
    signature: ClassVar[str] = "more inertia across the sheet than along it, and no more weight"
    source: ClassVar[str] = "potential flow around an accelerated plate (Brennen 1982)"
    typical: ClassVar[str] = "0.02 to 0.3 kg/m^2"
    varied: ClassVar[str] = "shorter and quicker strokes of the same speed (carried air answers to the acceleration)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (Coefficient(name="mass", unit="kg/m^2", scale=0.08, low=0.0),)

    mass: float  # kg/m^2

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, added_mass_kg_m2=values["mass"])

    def push(self, solver: Any, dt: float) -> None:
        """Inertia of the air before each face, shared among its corners."""
        wp.launch(
            carry_air,
            dim=len(solver.sheet.triangle),
            inputs=[solver.sheet, solver.now, self.mass, solver.second_order, dt],
            device=solver.model.device,
        )


@wp.kernel(enable_backward=False)
def carry_air(sheet: Sheet, now: Iterate, added: float, second_order: int, dt: float):
    """-m_a A / 3 (n . a) n on each corner, a its own acceleration as the step makes it, n at the step's beginning."""
    t = wp.tid()
    corner = sheet.triangle[t]
    origin = now.start[corner[0]]
    across = wp.cross(now.start[corner[1]] - origin, now.start[corner[2]] - origin)
    normal = across / wp.max(wp.length(across), 1.0e-20)
    along = wp.outer(normal, normal)
    share = added * sheet.triangle_area[t] / 3.0
    for i in range(3):
        v = corner[i]
        # acceleration(x) = rate^2 (x - start) + drift, by the rule that moves the vertex itself, see `advance.end_step`
        drift = -now.expected[v] / dt
        rate = 1.0 / dt
        if second_order != 0:
            speed = 0.5 * (now.expected[v] + now.before_speed[v])
            drift = -speed / dt
            if now.fresh[v] == 0:
                rate = 1.5 / dt
                kept = (now.start[v] - now.before[v]) / (2.0 * dt)
                drift = (-3.0 * kept - 4.0 * speed + now.before_speed[v]) / (2.0 * dt)
        wp.atomic_add(now.force, v, -share * (along * drift))
        wp.atomic_add(now.slope, v, share * rate * rate * along)
