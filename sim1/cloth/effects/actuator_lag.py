"""The robot follows its command late."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class ActuatorLag(Effect):
    """First order: tau dx/dt = command - x."""

    name: ClassVar[str] = "actuator_lag"
    signature: ClassVar[str] = "the whole cloth is late while the robot moves, and not while it swings freely"
    source: ClassVar[str] = "first-order actuator"
    typical: ClassVar[str] = "5 to 150 ms"
    varied: ClassVar[str] = "a sudden stop and 2 s of free swing (a lag shows while the robot moves, and not after)"
    delays: ClassVar[bool] = True
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="time_constant", unit="s", scale=0.03, low=0.0),
    )

    afar: ClassVar[tuple[dict[str, float], ...]] = tuple({"time_constant": s} for s in (0.06, 0.12, 0.2))

    time_constant: float  # s

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, lag_s=values["time_constant"])

    measured: ClassVar[bool] = True
