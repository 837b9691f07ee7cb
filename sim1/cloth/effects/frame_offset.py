"""Camera and robot frames differ."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class FrameOffset(Effect):
    """Reported marker = R(rotation vector) x + t."""

    name: ClassVar[str] = "frame_offset"
    signature: ClassVar[str] = "every marker is off by one rigid motion, at rest too"
    source: ClassVar[str] = "rigid registration error"
    typical: ClassVar[str] = "1 to 20 mm, 0.2 to 5 degrees"
    varied: ClassVar[str] = "the rig turned by 180 degrees about the vertical (an offset goes with the camera)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="tx", unit="m", scale=0.004),
        Coefficient(name="ty", unit="m", scale=0.004),
        Coefficient(name="tz", unit="m", scale=0.004),
        Coefficient(name="rx", unit="rad", scale=0.01),
        Coefficient(name="ry", unit="rad", scale=0.01),
        Coefficient(name="rz", unit="rad", scale=0.01),
    )

    tx: float  # m
    ty: float  # m
    tz: float  # m
    rx: float  # rad
    ry: float  # rad
    rz: float  # rad

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient, the turn taken about `world.frame_centre_m`."""
        turn, centre = (values["rx"], values["ry"], values["rz"]), np.array(world.frame_centre_m)
        away = centre - Rotation.from_rotvec(turn).apply(centre)
        shift = away + np.array([values["tx"], values["ty"], values["tz"]])
        return replace(world, frame_shift_m=tuple(shift.tolist()), frame_turn_rad=turn)

    @classmethod
    def published(cls, world: World, values: dict[str, float]) -> dict[str, float]:
        """The same about the origin."""
        names = (c.name for c in cls.coefficients)
        return dict(zip(names, (*world.frame_shift_m, *world.frame_turn_rad), strict=True))

    def act(self, world: World) -> World:
        """The world with this effect, whose parameters are about the origin."""
        return super().act(replace(world, frame_centre_m=(0.0, 0.0, 0.0)))

    measured: ClassVar[bool] = True
