"""An engine whose answer is known, for tests of searches."""

from dataclasses import dataclass, field

import numpy as np
from small_bundle import empty_bundle

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.patience import Patience
from sim1.mismatch.search import Unknowns, baseline

TRUE = np.array([0.7, -0.4])


@dataclass
class Straight:
    """Stands for the engine: residuals that are straight in z, or bent by so much, and a border that no simulation crosses."""

    border: float = np.inf
    bent: float = 0.0
    patience: Patience = field(default_factory=Patience)
    looks: int = 0  # how often slopes were asked for
    most_looks: int = 1000  # how often there are any

    def slopes(self, unknowns, z, names, first=0):
        self.looks += 1
        if self.looks > self.most_looks:
            raise NotConverged("recording only: twins find no next state at 1 s")
        slopes, bends, _ = self._numbers()
        bent = slopes + bends * self._warped(z)[1]
        return self.residuals(unknowns, z, names), {"only": bent[:, first:]}

    def residuals(self, unknowns, z, names):
        if np.abs(z).max() > self.border:
            raise NotConverged("recording only: no next state at 1 s")
        slopes, bends, noise = self._numbers()
        return {"only": slopes @ (z - TRUE) + bends @ self._warped(z)[0] + noise}

    def mesh_off(self, names):
        return {name: np.zeros(300) for name in names}

    def stretches(self, names):
        return {name: np.arange(300) // 25 for name in names}

    def _warped(self, z):
        off = z - TRUE
        return self.bent * off**2, 2.0 * self.bent * off

    def _numbers(self):
        stream = np.random.default_rng(1)
        slopes, bends = 20.0 * stream.standard_normal((2, 300, 2))
        return slopes, bends, stream.standard_normal(300)


def two_unknowns():
    """A model with two coefficients."""
    made = baseline(empty_bundle())
    two = tuple(Coefficient(name=name, unit="1", scale=1.0) for name in ("a", "b"))
    return Unknowns(base=made.base, nominal=two)
