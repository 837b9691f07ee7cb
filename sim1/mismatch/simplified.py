"""Simpler models from where a richer one arrived: what their own search stopped short of is no physics that the richer one has."""

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.decide import best_of
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import fit, promised
from sim1.mismatch.models import Model, judged
from sim1.mismatch.thresholds import Thresholds

STUCK = 5.0  # nats that a search from elsewhere must promise: two ends of one differ by less
MATTERS = 0.05  # of what the best is ahead, that it must promise, too: less says nothing else of who is named
MORE = 2  # iterations of the search from there


def simplified(engine: Engine, pool: list[Model], thresholds: Thresholds, names: tuple[str, ...]) -> list[Model]:
    """The pool with models that the best contains fitted from where the best arrived, if that is better.

    A search that stopped on the wrong side of a fold would else make the next coefficient look like physics.
    """
    best = best_of(pool, thresholds)
    kept = []
    for model in pool:
        inside = set(model.terms) < set(best.terms)
        kept.append(_from_there(engine, model, best, names) if inside and not engine.patience.over else model)
    return kept


def _from_there(engine: Engine, model: Model, other: Model, names: tuple[str, ...]) -> Model:
    """The model from where `other`, which contains it, arrived, if that is better; slopes are measured only if it is."""
    own, unknowns = len(model.fit.nominal_z), model.fit.unknowns
    low, high = unknowns.bounds()
    start = np.clip(np.concatenate([other.fit.nominal_z, model.fit.z[own:]]), low, high)
    slopes = {name: np.hstack([other.fit.slopes[name][:, :own], model.fit.slopes[name][:, own:]]) for name in names}
    try:
        looked = engine.residuals(unknowns, start, names), slopes
        there = fit(engine, unknowns, start, names, temper=model.fit.temper, most=0, given=looked, settle=False)
        if there.cost - promised(there) > model.fit.cost - max(STUCK, MATTERS * (model.fit.cost - other.fit.cost)):
            return model
        found = fit(engine, unknowns, start, names, temper=model.fit.temper, most=MORE, given=looked, exact=False)
    except NotConverged:
        return model
    again = judged(found, model.fit.temper, model.variants)
    return again if again.score < model.score else model
