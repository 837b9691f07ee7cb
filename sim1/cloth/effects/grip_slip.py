"""Cloth creeps out of the gripper under load."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect, Site
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class GripSlip(Effect):
    """The grip's places move by rate (|F| - threshold) along the load F of the grip."""

    name: ClassVar[str] = "grip_slip"
    signature: ClassVar[str] = "the held edge leaves its place under load and does not come back"
    source: ClassVar[str] = "viscous creep above a threshold (Bingham)"
    typical: ClassVar[str] = "0.1 to 2 N, 1 to 100 mm/(N s)"
    varied: ClassVar[str] = (
        "a longer pull, and 1 s of rest in the first pose after it (what slipped does not come back)"
    )
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="rate", unit="m/(N s)", scale=0.01, low=0.0),
        Coefficient(name="threshold", unit="N", scale=0.4, kind="log", centre=0.3, low=0.001, high=100.0, shape=True),
    )

    threshold: float  # N
    rate: float  # m/(N s)

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, slip_threshold_n=values["threshold"], slip_rate_m_n_s=values["rate"])

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Thresholds below the load that the sheet's weight puts on a grip, and above: taut ones pull at up to twelve times that."""
        return [{"threshold": share * site.grip_load_n} for share in (0.3, 0.7, 1.1, 1.5, 3.0, 6.0, 12.0)]

    measured: ClassVar[bool] = True
    beyond: ClassVar[bool] = True
