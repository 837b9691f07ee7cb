"""A steady uniform air stream, with the drag that it brings."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from sim1.cloth.effects.air_drag import AIR_DENSITY_KG_M3, push_of_air
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class Wind(Effect):
    """Drag of air that moves: v of the drag law is relative to the stream; c_normal is the stream's drag coefficient."""

    name: ClassVar[str] = "wind"
    signature: ClassVar[str] = "a steady push that is strongest where the sheet faces one direction, also at rest"
    source: ClassVar[str] = "quadratic drag of a plate in a stream (Hoerner 1965, chapter 3)"
    typical: ClassVar[str] = "0.1 to 2 m/s"
    varied: ClassVar[str] = "the rig turned by 90 degrees about the vertical (a stream keeps its direction in the room)"
    testing: ClassVar[str | None] = (
        "film the same motion with the rig half a metre aside: a stream is the same there, a jet is not"
    )
    widens: ClassVar[str] = "air_drag"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="c_normal", unit="1", scale=1.3, low=0.0),
        Coefficient(name="vx", unit="m/s", scale=0.4, shape=True),
        Coefficient(name="vy", unit="m/s", scale=0.4, shape=True),
        Coefficient(name="vz", unit="m/s", scale=0.4, shape=True),
    )

    vx: float  # m/s
    vy: float  # m/s
    vz: float  # m/s
    c_normal: float = 1.3  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, air_normal=values["c_normal"], wind_m_s=(values["vx"], values["vy"], values["vz"]))

    def push(self, solver: Any, dt: float) -> None:
        """Drag relative to the stream, at the expected velocity."""
        push_of_air(solver, dt, AIR_DENSITY_KG_M3, (self.c_normal, 0.0), (self.vx, self.vy, self.vz))

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Streams along both directions of the three axes: without one, wind has no fingerprint."""
        del site
        return [
            {"vx": speed * (axis == 0), "vy": speed * (axis == 1), "vz": speed * (axis == 2)}
            for axis in range(3)
            for speed in (-0.6, 0.6)
        ]
