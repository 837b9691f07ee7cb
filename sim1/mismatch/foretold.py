"""What motion that no fit has seen says of two models."""

from dataclasses import dataclass

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.compare import mesh_error
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import cost_of, temper_of
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


def foretold_by(engine: Engine, model: Model, names: tuple[str, ...], finer: int | None = None) -> Foretold:
    """Markers by recording, from rest and drives alone; what cannot be simulated is told apart and stops nothing."""
    told = engine.foretold(model.fit.unknowns.world(model.fit.z), names, finer)
    return Foretold(
        markers_m={name: one for name, one in told.items() if not isinstance(one, NotConverged)},
        lost={name: str(one) for name, one in told.items() if isinstance(one, NotConverged)},
    )


def nats_against(
    engine: Engine, null: Model, models: list[Model], foretold: ByTerms, names: tuple[str, ...]
) -> tuple[dict[tuple[str, ...], float], dict[tuple[str, ...], str]]:
    """By how many nats recordings are less likely foretold with a model than with the baseline, by effects; below 0: more likely.

    Counted as evidence is in a fit: what the mesh gets wrong, the larger of both where they differ, is carried as discrepancy, and
    neighbours in time count as one. A sheet that snaps to one side on one mesh and to the other on the next is no witness. The second
    part is of models that could not be asked, and why: with them or with the baseline, on one of the meshes, no simulation follows.
    """
    if not models:
        return {}, {}
    rough = {one.terms: foretold_by(engine, one, names, engine.other_mesh) for one in (null, *models)}
    against, unasked = {}, {}
    for terms in (model.terms for model in models):
        lost = [why for one in ((), terms) for told in (foretold[one], rough[one]) for why in told.lost.values()]
        if lost:
            unasked[terms] = lost[0]
            continue
        cost = 0.0
        for name in names:
            pair = [foretold[one].markers_m[name] for one in ((), terms)]
            one = engine.observed(name)
            mesh_m = [
                mesh_error(one, fine - rough[k].markers_m[name]) for fine, k in zip(pair, ((), terms), strict=True)
            ]
            with engine.aside():
                one = engine.carry(name, np.maximum(*mesh_m))
                before, after = ({name: one.white(one.reduce(fine) - one.measured_m)} for fine in pair)
                temper = temper_of(engine, before, (name,))
            cost += cost_of(after, (name,), temper) - cost_of(before, (name,), temper)
        against[terms] = cost
    return against, unasked
