"""The grip yields elastically."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class GripCompliance(Effect):
    """Each grip's jaw shifts as a whole, on a spring of `stiffness`, and all that it holds with it."""

    name: ClassVar[str] = "grip_compliance"
    signature: ClassVar[str] = "the held edge gives way under load and comes back"
    source: ClassVar[str] = "linear spring"
    typical: ClassVar[str] = "50 to 2000 N/m"
    varied: ClassVar[str] = "a harder pull, and 1 s of rest in the first pose after it (what gave way comes back)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="compliance", unit="m/N", scale=2e-3, low=0.0, twin_z=1e-6),
    )

    limits: ClassVar[dict[str, tuple[float, float]]] = {"stiffness": (1e-6, math.inf)}

    stiffness: float  # N/m, of a grip as a whole

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, compliance_m_n=values["compliance"])

    @classmethod
    def published(cls, world: World, values: dict[str, float]) -> dict[str, float]:
        """Stiffness from compliance."""
        del world
        return {"stiffness": 1.0 / max(values["compliance"], 1e-6)}

    @classmethod
    def searched(cls, parameters: dict[str, float]) -> dict[str, float]:
        """Compliance from stiffness."""
        return {"compliance": 1.0 / parameters["stiffness"]}

    @classmethod
    def units(cls) -> dict[str, str]:
        """Unit of each parameter of a model file."""
        return {"stiffness": "N/m"}

    measured: ClassVar[bool] = True
