"""The table: sticking, direction, speed, clinging."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.world import Environment, State, World


@dataclass
class StaticFriction(Effect):
    """Stuck cloth holds more than sliding cloth: stick and slip are states (Karnopp 1985), with Stribeck's fall between.

    It falls exponentially (Tustin 1947), not as a bell curve: at `stribeck_speed` both have fallen by the same, below it this one has fallen further. `ratio`
    is that of the largest friction before it slides to the one at speed, in both.
    """

    name: ClassVar[str] = "static_friction"
    formula: ClassVar[str] = (
        "sticks until ratio * mu * N, slides with mu N (1 + (ratio - 1) exp(-v / stribeck_speed)), "
        "sticks again at zero speed"
    )

    def environment(self, environment: Environment) -> Environment:
        """Another friction law."""
        friction = replace(
            environment.friction,
            static_ratio=self.parameters["ratio"],
            stribeck_speed_m_s=self.extras["stribeck_speed"],
        )
        return replace(environment, friction=friction)


@dataclass
class AnisotropicFriction(Effect):
    """Friction that depends on the direction on the table."""

    name: ClassVar[str] = "anisotropic_friction"
    formula: ClassVar[str] = (
        "-N (mu_x^2 v_x, mu_y^2 v_y) / |(mu_x v_x, mu_y v_y)|: largest dissipation over an ellipse of forces"
    )

    def environment(self, environment: Environment) -> Environment:
        """Another friction law."""
        friction = replace(environment.friction, mu_x=self.parameters["mu_x"], mu_y=self.parameters["mu_y"])
        return replace(environment, friction=friction)


@dataclass
class ViscousFriction(Effect):
    """Outside the table: friction grows with the sliding speed, as on a damp table."""

    name: ClassVar[str] = "viscous_friction"
    formula: ClassVar[str] = "mu (fast_ratio + (1 - fast_ratio) exp(-v / fading_speed)), fast_ratio above 1"

    def environment(self, environment: Environment) -> Environment:
        """Another friction law."""
        friction = replace(
            environment.friction,
            fast_ratio=self.parameters["fast_ratio"],
            fading_speed_m_s=self.parameters["fading_speed"],
        )
        return replace(environment, friction=friction)


@dataclass
class Adhesion(Effect):
    """A traction that holds the cloth to the table and fades over `reach`; it also presses, so friction grows with it."""

    name: ClassVar[str] = "adhesion"
    formula: ClassVar[str] = (
        "traction pressure * (1 - gap / reach) towards the table below the reach; friction acts on the sum"
    )

    def begin(self, world: World) -> None:
        """Where the cloth touches."""
        table = world.environment.table_m
        self._level = None if table is None else table + world.cloth.thickness_m / 2
        self._area = world.sheet.grid.area_m2

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Pull down what is near."""
        if self._level is not None:
            near = np.clip(1 - (state.x[2] - self._level) / self.extras["reach"], 0.0, 1.0)
            out_n[2] -= self.parameters["pressure"] * self._area * near
