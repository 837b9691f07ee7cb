"""A leader that acts above a threshold is looked at with others: a trace of it told nothing of how high that is.

Screening chooses thresholds by what a trace of an effect would do: of a cloth that slips out of its grips, a low one that is crossed all the time. A search
from there ends with a low rate at a low threshold, though a high rate at a high one fits far better, as the way between leads uphill. So a leader is
simulated once with a usual strength at every threshold that was screened, all else where the baseline has it; one that costs less there, unfitted, than
the fitted leader is where the search begins once more.
"""

import numpy as np

from sim1.cloth.effects import Site
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit, cost_of, fit
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Term

LEADING = 45.0  # nats that an effect must have gained
STEPS = 8


def elsewhere(engine: Engine, base: Fit, found: Fit, candidate: Candidate, site: Site) -> Fit:
    """`found`, or what the same effect comes to from another threshold where that is better.

    `candidate` is what the screening said beside `base`.
    """
    effect = candidate.term.effect
    if not effect.beyond or base.cost - found.cost < LEADING:
        return found
    least, start = found.cost, None
    for variant in effect.variants(site):
        if engine.patience.over:
            return found
        term = Term.of(effect, variant)
        unknowns = base.unknowns.with_terms(*base.unknowns.terms, term)
        z = np.concatenate([base.z, [0.0 if one.shape else 1.0 for one in term.coefficients]])
        try:
            residuals = engine.residuals(unknowns, z, found.names)
        except NotConverged:
            continue
        cost = cost_of(residuals, found.names, base.temper) + 0.5 * float(z @ z)
        if cost < least:
            least, start = cost, (unknowns, z)
    if start is None:
        return found
    try:
        again = fit(engine, *start, found.names, temper=base.temper, most=STEPS)
    except NotConverged:
        return found
    return again if again.cost < found.cost else found
