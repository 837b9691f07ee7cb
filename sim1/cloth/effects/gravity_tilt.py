"""The rig is not level."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class GravityTilt(Effect):
    """g = Ry(tilt_y) Rx(tilt_x) (0, 0, -9.81)."""

    name: ClassVar[str] = "gravity_tilt"
    signature: ClassVar[str] = "hangs askew by one angle in space, at rest too, whatever its pose"
    source: ClassVar[str] = "rotation of gravity"
    typical: ClassVar[str] = "0.5 to 6 degrees"
    varied: ClassVar[str] = "the rig turned by 180 degrees about the vertical (a tilt goes with the room)"
    testing: ClassVar[str | None] = (
        "hang a plumb line beside the rig: a tilt pulls it, too, a static charge or a magnet does not"
    )
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="tilt_x", unit="rad", scale=0.03),
        Coefficient(name="tilt_y", unit="rad", scale=0.03),
    )

    tilt_x: float  # rad
    tilt_y: float  # rad

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, tilt_rad=(values["tilt_x"], values["tilt_y"]))

    measured: ClassVar[bool] = True
