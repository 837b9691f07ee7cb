"""The cloth at rest is curled, not flat."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from sim1.cloth.avbd.threads import answers_of
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class RestCurvature(Effect):
    """Bending energy B/2 |kappa - kappa_0|^2, positive towards the normal u x v."""

    name: ClassVar[str] = "rest_curvature"
    signature: ClassVar[str] = "leans to one side of its surface whatever the motion, most where nothing holds it"
    source: ClassVar[str] = "natural curvature of a plate"
    typical: ClassVar[str] = "0.5 to 10 1/m"
    varied: ClassVar[str] = "the cloth turned over (it then leans to the other side)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="kappa_u", unit="1/m", scale=2.5),
        Coefficient(name="kappa_v", unit="1/m", scale=2.5),
    )

    afar: ClassVar[tuple[dict[str, float], ...]] = tuple(
        {"kappa_u": 8.0 * math.cos(k * math.pi / 4), "kappa_v": 8.0 * math.sin(k * math.pi / 4)} for k in range(8)
    )  # a strong curl, every way

    kappa_u: float  # 1/m
    kappa_v: float  # 1/m

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, curl_1_m=(values["kappa_u"], values["kappa_v"]))

    def shape(self, solver: Any) -> None:
        """Other angles at rest."""
        sheet = solver.sheet
        curl = answers_of(solver.hinge_corners_m, solver.warp) @ [self.kappa_u, self.kappa_v, 0.0]
        sheet.hinge_angle.assign(sheet.hinge_angle.numpy() + curl.astype(np.float32))
