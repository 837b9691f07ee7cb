"""The cloth clings to the table."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.avbd.touch import Touches
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class Adhesion(Effect):
    """Attraction `pressure` per area in contact, gone over a gap of `reach`: peeling takes pressure times reach over two."""

    name: ClassVar[str] = "adhesion"
    signature: ClassVar[str] = "lifts late from the table, and needs more force to slide than its weight explains"
    source: ClassVar[str] = "pull-off pressure of textiles on smooth tables"
    typical: ClassVar[str] = "0.1 to 5 Pa"
    varied: ClassVar[str] = "lifted slowly, without sliding (what clings lifts late)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="pressure", unit="Pa", scale=1.0, low=0.0),
        Coefficient(name="reach", unit="m", scale=0.7, kind="log", centre=5e-4, low=1e-4, high=1e-2, shape=True),
    )

    pressure: float  # Pa
    reach: float = 5e-4  # m

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, adhesion_pa=values["pressure"], cling_m=values["reach"])

    def push(self, solver: Any, dt: float) -> None:
        """Pull on each face that is near the table; what it adds to the load of contacts, friction feels by itself."""
        del dt
        wp.launch(
            cling,
            dim=len(solver.sheet.triangle),
            inputs=[solver.sheet, solver.now, solver.solids, solver.table, self.pressure, self.reach],
            device=solver.model.device,
        )

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Clinging by contact alone, and by fibres or charges that reach farther."""
        del site
        return [{"reach": start} for start in (5e-4, 2e-3)]

    on_table: ClassVar[bool] = True
    afar: ClassVar[tuple[dict[str, float], ...]] = tuple({"pressure": pa, "reach": 1e-3} for pa in (1.0, 2.0, 4.0))

    @classmethod
    def relieves(cls, world: World, values: dict[str, float]) -> dict[str, float]:
        """What slides is held back by friction of its weight and of what pulls it down."""
        load_pa = world.area_density_kg_m2 * math.hypot(*world.gravity_m_s2)
        return {"friction": load_pa / (load_pa + values["pressure"])}


@wp.kernel(enable_backward=False)
def cling(sheet: Sheet, now: Iterate, solids: Touches, table: int, pressure: float, reach: float):
    """Attraction of each corner's third of a face by the gap that the step begins with.

    By the vertex's own contact: those of edges and faces, where they are looked for, tell of the same third again.
    """
    t = wp.tid()
    corner = sheet.triangle[t]
    third = sheet.triangle_area[t] / 3.0
    for i in range(3):
        v = corner[i]
        node = int(solids.head[v])
        while node >= 0:
            record = node / 4
            if solids.shape[record] == table and solids.vertex[record][1] < 0:
                normal = solids.normal[record]
                gap = wp.dot(normal, now.start[v]) - solids.offset[record]
                left = wp.clamp(1.0 - gap / reach, 0.0, 1.0)
                wp.atomic_add(now.force, v, -pressure * third * left * normal)
            node = int(solids.after[node])
