"""Effects that are sought from afar as well: the way to a clock a quarter of a second late is not downhill.

Slopes at nothing tell a small offset. Where markers come late by a good part of a swing, the cost between rises, and a search from nothing
gets stuck near it, with a baseline that was bent to imitate the delay. So a few values far off are simulated, from the baseline as it was
fitted and as it was before any fit, and the best one is the start of a calibration of its own.
"""

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.excess import mean_square
from sim1.mismatch.fit import Fit, Tempers, cheapest, cost_at, fit
from sim1.mismatch.models import Model, calibrate, judged
from sim1.mismatch.screen import possible, site_of
from sim1.mismatch.search import Term

EXCESS = 2.0  # mean squared residual of a baseline from which it is worth it
STEPS = 2  # of the search from where that ends


def from_afar(engine: Engine, base: Fit, temper: Tempers, names: tuple[str, ...]) -> tuple[Model, ...]:
    """Models with one effect more, found from values far from nothing; none where the baseline leaves little, or nothing is gained."""
    if engine.patience.over or mean_square(base) < EXCESS:
        return ()
    world = base.unknowns.world(base.z)
    found = (
        _fitted(engine, base, Term.of(effect), temper, names)
        for effect in possible(site_of(engine, world), base.unknowns.terms)
        if effect.afar and not engine.patience.over
    )
    return tuple(model for model in found if model is not None)


def _fitted(engine: Engine, base: Fit, term: Term, temper: Tempers, names: tuple[str, ...]) -> Model | None:
    unknowns = base.unknowns.with_terms(*base.unknowns.terms, term)
    before = np.concatenate([np.zeros(len(base.nominal_z)), base.z[len(base.nominal_z) :]])
    starts = []
    for values in term.effect.afar:
        far = np.array([c.z(values.get(c.name, c.centre)) for c in term.coefficients])
        starts += [np.concatenate([base.z, far]), np.concatenate([before, far])]
    try:
        with engine.aside():  # all models are compared by one idea of what mesh and step get wrong
            engine.finer = max(engine.finest - 1, 0)  # where a calibration begins, and several times as fast
            least = cost_at(engine, base.unknowns, base.z, names, temper)
            start = cheapest(engine, [(unknowns, z) for z in starts], least, names, temper)
            if start is None:
                return None
            alone = calibrate(engine, *start, names, lambda share: None)
        found = fit(engine, unknowns, alone.z, names, temper=temper, most=STEPS)
    except NotConverged:  # its twins find no way; the excess that led here keeps the verdict from `none`
        return None
    return judged(found, temper, len(term.effect.afar))
