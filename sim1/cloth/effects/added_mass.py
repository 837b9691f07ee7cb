"""Air carried along by a moving sheet."""

from dataclasses import dataclass, replace
from typing import ClassVar

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class AddedMass(Effect):
    """f = -m_a (n . a) n per area."""

    name: ClassVar[str] = "added_mass"
    signature: ClassVar[str] = "more inertia across the sheet than along it, and no more weight"
    source: ClassVar[str] = "potential flow around an accelerated plate (Brennen 1982)"
    typical: ClassVar[str] = "0.02 to 0.3 kg/m^2"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (Coefficient(name="mass", unit="kg/m^2", scale=0.08, low=0.0),)

    mass: float  # kg/m^2

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, added_mass_kg_m2=values["mass"])
