"""How a coefficient is searched: one scale for all, on which 0 means that the effect is absent and 1 is a typical strength."""

import math
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class Coefficient:
    """One number of an effect, or of the baseline, that recordings can tell.

    A search works on z with the prior N(0, 1): value = centre + scale z, or centre exp(scale z).
    """

    name: str
    unit: str
    scale: float
    kind: Literal["linear", "log"] = "linear"
    centre: float = 0.0  # of a strength: the value at which the effect is absent
    low: float = -math.inf
    high: float = math.inf
    twin_z: float = 2e-5  # how far a twin's value lies from the base's: linear still, and well above round-off
    farthest_z: float = 3.0  # a step of a search changes it by no more
    shape: bool = False  # says where or from when the effect acts, and nothing while its strength is 0

    def value(self, z: float) -> float:
        """The coefficient at `z`, inside its limits."""
        return min(max(self.unlimited(z), self.low), self.high)

    def unlimited(self, z: float) -> float:
        """The coefficient at `z`, wherever its limits are."""
        return self.centre + self.scale * z if self.kind == "linear" else self.centre * math.exp(self.scale * z)

    def z(self, value: float) -> float:
        """The inverse of `value`."""
        if self.kind == "linear":
            return (value - self.centre) / self.scale
        return math.log(value / self.centre) / self.scale
