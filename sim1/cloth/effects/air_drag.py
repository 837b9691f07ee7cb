"""Pressure and skin drag of still air on each face."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from sim1.cloth.avbd.iterate import Iterate
from sim1.cloth.avbd.sheet import Sheet
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World

AIR_DENSITY_KG_M3 = 1.2  # dry, 20 C, sea level


@dataclass(frozen=True, kw_only=True)
class AirDrag(Effect):
    """F = -1/2 rho A (c_n |v.n| (v.n) n + c_t |v_t| v_t) per face, v the mean velocity of its corners."""

    name: ClassVar[str] = "air_drag"
    signature: ClassVar[str] = (
        "braking that grows with the square of the speed across the sheet, and not with its weight"
    )
    source: ClassVar[str] = (
        "quadratic drag of a plate, split into normal and tangential parts (Wilson et al. 2014, section 3)"
    )

    typical: ClassVar[str] = (
        "c_normal 1.1 to 2 in steady motion, 5 to 10 in small oscillation; c_tangential 0.005 to 0.1"
    )
    varied: ClassVar[str] = "twice as fast (drag grows with the square of the speed)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="c_normal", unit="1", scale=1.5, low=0.0),
        Coefficient(name="c_tangential", unit="1", scale=0.05, low=0.0),
    )

    c_normal: float  # 1
    c_tangential: float = 0.0  # 1
    air_density_kg_m3: float = AIR_DENSITY_KG_M3

    limits: ClassVar[dict[str, tuple[float, float]]] = {"air_density_kg_m3": (0.0, math.inf)}
    fixed: ClassVar[dict[str, str]] = {"air_density_kg_m3": "kg/m^3"}

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, air_normal=values["c_normal"], air_skin=values["c_tangential"])

    def push(self, solver: Any, dt: float) -> None:
        """Drag at the expected velocity, and its slope, so that a large coefficient brakes and does not throw back."""
        push_of_air(solver, dt, self.air_density_kg_m3, (self.c_normal, self.c_tangential), (0.0, 0.0, 0.0))


def push_of_air(
    solver: Any, dt: float, density_kg_m3: float, drag: tuple[float, float], stream_m_s: tuple[float, float, float]
) -> None:
    """Drag of air that moves, coefficients across and along the faces, on `solver.now`."""
    wp.launch(
        drag_faces,
        dim=len(solver.sheet.triangle),
        inputs=[
            solver.sheet,
            solver.now,
            0.5 * density_kg_m3 * drag[0],
            0.5 * density_kg_m3 * drag[1],
            wp.vec3(*stream_m_s),
            solver.rate(dt),
            dt,
        ],
        device=solver.model.device,
    )


@wp.kernel(enable_backward=False)
def drag_faces(
    sheet: Sheet, now: Iterate, normal_drag: float, skin_drag: float, stream: wp.vec3, rate: float, dt: float
):
    """Drag of each face on its three corners: value at the expected velocity, linear in the corner's velocity."""
    t = wp.tid()
    corner = sheet.triangle[t]
    a = now.start[corner[0]]
    across = wp.cross(now.start[corner[1]] - a, now.start[corner[2]] - a)
    twice = wp.max(wp.length(across), 1.0e-20)
    normal = across / twice
    velocity = (now.expected[corner[0]] + now.expected[corner[1]] + now.expected[corner[2]]) / 3.0 - stream
    through = wp.dot(velocity, normal)
    along = velocity - through * normal
    pressure = 0.5 * twice * normal_drag * wp.abs(through)
    skin = 0.5 * twice * skin_drag * wp.length(along)
    force = -(pressure * through * normal + skin * along) / 3.0
    outer = wp.outer(normal, normal)
    # Half of the derivative of v |v|: the secant, which never pushes beyond rest; as if the other corners moved alike.
    slope = (pressure * outer + skin * (wp.identity(n=3, dtype=float) - outer)) / 3.0
    for i in range(3):
        v = corner[i]
        # velocity(x) = rate (x - start) + drift; force(x) = force - slope (velocity(x) - expected)
        drift = (now.start[v] - now.before[v]) * ((1.0 - rate * dt) / dt)
        wp.atomic_add(now.force, v, force + slope * (now.expected[v] - drift))
        wp.atomic_add(now.slope, v, rate * slope)
