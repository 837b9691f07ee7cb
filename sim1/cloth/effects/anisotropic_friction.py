"""Table friction depends on the direction."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import warp as wp

from sim1.cloth.avbd.touch import Touches
from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.effects.effect import Effect
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class AnisotropicFriction(Effect):
    """Coulomb friction mu_x along the world's x, mu_y along y."""

    name: ClassVar[str] = "anisotropic_friction"
    signature: ClassVar[str] = "slides more easily along one axis of the table than along the other"
    source: ClassVar[str] = "orthotropic Coulomb friction (Zmitrowicz 1981)"
    typical: ClassVar[str] = "ratio 0.5 to 2"
    varied: ClassVar[str] = "along the table's other axis (friction goes with the table, not with the threads)"
    coefficients: ClassVar[tuple[Coefficient, ...]] = (
        Coefficient(name="ratio", unit="1", scale=0.5, kind="log", centre=1.0, low=0.02, high=50.0),
    )

    limits: ClassVar[dict[str, tuple[float, float]]] = {"mu_x": (1e-9, math.inf), "mu_y": (1e-9, math.inf)}

    mu_x: float  # 1
    mu_y: float  # 1

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        return replace(world, friction_ratio=values["ratio"])

    def push(self, solver: Any, dt: float) -> None:
        """Other friction along either axis of the table, whatever the table's own is."""
        del dt
        mean = 0.5 * (self.mu_x + self.mu_y)
        wp.launch(
            lean,
            dim=solver.solids.capacity,
            inputs=[solver.solids, solver.table, mean, 0.5 * (self.mu_x - self.mu_y) / max(mean, 1e-9)],
            device=solver.model.device,
        )

    on_table: ClassVar[bool] = True
    rank: ClassVar[int] = 1  # sticking multiplies what slides

    @classmethod
    def published(cls, world: World, values: dict[str, float]) -> dict[str, float]:
        """Both coefficients, from the mean that the baseline fits and their ratio."""
        root = values["ratio"] ** 0.5
        return {"mu_x": world.friction * root, "mu_y": world.friction / root}

    @classmethod
    def searched(cls, parameters: dict[str, float]) -> dict[str, float]:
        """Their ratio; the mean is the world's."""
        return {"ratio": parameters["mu_x"] / parameters["mu_y"]}

    @classmethod
    def units(cls) -> dict[str, str]:
        """Unit of each parameter of a model file."""
        return {"mu_x": "1", "mu_y": "1"}

    def act(self, world: World) -> World:
        """The world with both coefficients."""
        return super().act(replace(world, friction=(self.mu_x * self.mu_y) ** 0.5))


@wp.kernel(enable_backward=False)
def lean(solids: Touches, table: int, mean: float, skew: float):
    """Mean friction of each contact with the table, and how much more it is along x than along y."""
    c = wp.tid()
    if solids.shape[c] == table:
        solids.friction[c] = mean
        solids.skew[c] = skew
