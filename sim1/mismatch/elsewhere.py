"""A leader that acts above a threshold is looked at with others: a trace of it told nothing of how high that is.

Screening chooses thresholds by what a trace of an effect would do: of a cloth that slips out of its grips, a low one that is crossed all the time. A search
from there ends with a low rate at a low threshold, though a high rate at a high one fits far better, as the way between leads uphill. So a leader is
simulated once with a usual strength at every threshold that was screened, all else where the baseline has it; one that costs less there, unfitted, than
the fitted leader is where the search begins once more.
"""

import numpy as np

from sim1.cloth.effects import Site
from sim1.mismatch.afresh import USUAL_Z, begun_again
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import PROMISING, Fit, cheapest
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Term


def elsewhere(engine: Engine, base: Fit, found: Fit, candidate: Candidate, site: Site) -> Fit:
    """`found`, or what the same effect comes to from another threshold where that is better.

    `candidate` is what the screening said beside `base`.
    """
    effect = candidate.term.effect
    if not effect.beyond or base.cost - found.cost < PROMISING:
        return found
    terms = [Term.of(effect, variant) for variant in effect.variants(site)]
    starts = [
        (
            base.unknowns.with_terms(*base.unknowns.terms, term),
            np.concatenate([base.z, [0.0 if one.shape else USUAL_Z for one in term.coefficients]]),
        )
        for term in terms
    ]
    start = cheapest(engine, starts, found.cost, found.names, base.temper)
    return begun_again(engine, base, found, *start) if start else found
