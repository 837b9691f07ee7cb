"""What motion that no fit has seen says of two models."""

import numpy as np

from sim1.mismatch.compare import mesh_error
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import cost_of, temper_of
from sim1.mismatch.models import Model


def foretold_by(engine: Engine, model: Model, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Markers (N, M, 3) by recording, from rest and drives alone."""
    return engine.foretell(model.fit.unknowns.world(model.fit.z), names)


def nats_against(
    engine: Engine, null: Model, model: Model, foretold: tuple[dict, dict], names: tuple[str, ...]
) -> float:
    """By how much recordings are less likely foretold with a model than with the baseline; below 0: more likely.

    `foretold`: markers (N, M, 3) by recording of the baseline and of the model. Counted as evidence is in a fit: what the mesh gets
    wrong, the larger of both where they differ, is carried as discrepancy, and neighbours in time count as one. A sheet that snaps
    to one side on one mesh and to the other on the next is no witness.
    """
    cost = 0.0
    rough = [
        engine.foretell(one.fit.unknowns.world(one.fit.z), names, finer=engine.other_mesh) for one in (null, model)
    ]
    for name in names:
        one = engine.observed(name)
        mesh_m = [mesh_error(one, fine[name] - coarse[name]) for fine, coarse in zip(foretold, rough, strict=True)]
        with engine.aside():
            one = engine.carry(name, np.maximum(*mesh_m))
            before, after = ({name: one.white(one.reduce(fine[name]) - one.measured_m)} for fine in foretold)
            temper = temper_of(engine, before, (name,))
        cost += cost_of(after, (name,), temper) - cost_of(before, (name,), temper)
    return cost
