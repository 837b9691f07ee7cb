"""Marker and robot clocks differ."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class ClockOffset(Effect):
    """Marker time stamp = true time + offset."""

    name: ClassVar[str] = "clock_offset"
    signature: ClassVar[str] = "everything is early or late by the same time, free decay too"
    source: ClassVar[str] = "pure delay of one clock against the other"
    typical: ClassVar[str] = "10 to 300 ms"
    varied: ClassVar[str] = "a sudden stop and 2 s of free swing (an offset shifts the free swing too)"
    delays: ClassVar[bool] = True
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="offset", unit="s", scale=0.1, low=-0.3, high=0.5),
    )

    afar: ClassVar[tuple[dict[str, float], ...]] = tuple({"offset": s} for s in (-0.2, -0.1, 0.1, 0.2, 0.3))

    offset: float  # s

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, clock_offset_s=values["offset"])

    measured: ClassVar[bool] = True
