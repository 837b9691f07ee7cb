"""What motion that no fit has seen says of two models."""

import numpy as np

from sim1.mismatch.compare import mesh_error
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import cost_of, temper_of
from sim1.mismatch.models import Model

type Foretold = dict[tuple[str, ...], dict[str, np.ndarray]]  # by effects and recording


def foretold_by(engine: Engine, model: Model, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Markers (N, M, 3) by recording, from rest and drives alone."""
    return engine.foretell(model.fit.unknowns.world(model.fit.z), names)


def nats_against(
    engine: Engine, null: Model, models: list[Model], foretold: Foretold, names: tuple[str, ...]
) -> dict[tuple[str, ...], float]:
    """By how many nats recordings are less likely foretold with a model than with the baseline, by effects; below 0: more likely.

    `foretold`: by effects, () the baseline's, markers (N, M, 3) by recording. Counted as evidence is in a fit: what the mesh gets
    wrong, the larger of both where they differ, is carried as discrepancy, and neighbours in time count as one. A sheet that snaps
    to one side on one mesh and to the other on the next is no witness.
    """
    if not models:
        return {}
    rough = {
        one.terms: engine.foretell(one.fit.unknowns.world(one.fit.z), names, finer=engine.other_mesh)
        for one in (null, *models)
    }
    against = {}
    for terms in (model.terms for model in models):
        cost = 0.0
        for name in names:
            pair = [foretold[one][name] for one in ((), terms)]
            one = engine.observed(name)
            mesh_m = [mesh_error(one, fine - rough[k][name]) for fine, k in zip(pair, ((), terms), strict=True)]
            with engine.aside():
                one = engine.carry(name, np.maximum(*mesh_m))
                before, after = ({name: one.white(one.reduce(fine) - one.measured_m)} for fine in pair)
                temper = temper_of(engine, before, (name,))
            cost += cost_of(after, (name,), temper) - cost_of(before, (name,), temper)
        against[terms] = cost
    return against
