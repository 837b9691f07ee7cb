"""What a model foretells of recordings from rest and drives alone."""

from dataclasses import dataclass

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.models import Model


@dataclass(frozen=True, kw_only=True)
class Foretold:
    """What a model says of recordings from rest and drives alone."""

    markers_m: dict[str, np.ndarray]  # (N, M, 3) by recording
    lost: dict[str, str]  # recordings that no simulation with it follows, and where it stops

    def of(self, names: tuple[str, ...]) -> "Foretold":
        """What it says of these recordings alone."""
        return Foretold(
            markers_m={name: one for name, one in self.markers_m.items() if name in names},
            lost={name: why for name, why in self.lost.items() if name in names},
        )

    def and_of(self, others: "Foretold") -> "Foretold":
        """Together with what the same model says of other recordings."""
        return Foretold(markers_m=self.markers_m | others.markers_m, lost=self.lost | others.lost)


type ByTerms = dict[tuple[str, ...], Foretold]  # by effects, () the baseline's


def foretold_by(engine: Engine, model: Model, names: tuple[str, ...]) -> Foretold:
    """Markers by recording, from rest and drives alone; what cannot be simulated is told apart and stops nothing."""
    told = engine.foretold(model.fit.unknowns.world(model.fit.z), names)
    return Foretold(
        markers_m={name: one for name, one in told.items() if not isinstance(one, NotConverged)},
        lost={name: str(one) for name, one in told.items() if isinstance(one, NotConverged)},
    )
