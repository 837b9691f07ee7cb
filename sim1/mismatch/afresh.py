"""A search that a fold holds up begins once more from beyond it.

Where a sheet wrinkles, the cost of a model is rough: beside the baseline, small strengths of an effect only move the wrinkles, and no step along
the slopes leads far down though these still promise tens of nats. So the new coefficients are taken, in the proportions that the screening found, as far
as is usual for an effect, with everything else where the baseline has it, and the search goes on from there, however much that costs at first.
"""

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit, fit, promised
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Unknowns

HELD_UP = 20.0  # nats that were hoped for: by the screening, or by the slopes where the search ended
ARRIVED = 0.67  # of them; screening on a coarser mesh foretells to a quarter
USUAL_Z = 1.0  # of the strongest new coefficient, in prior standard deviations
STEPS = 8


def afresh(engine: Engine, base: Fit, stuck: Fit, candidate: Candidate) -> Fit:
    """`stuck`, or what the same effects come to from usual strengths where that is better.

    `candidate` is what the screening said beside `base`.
    """
    hoped = max(candidate.gain, promised(stuck))
    if hoped < HELD_UP or base.cost - stuck.cost > ARRIVED * hoped or engine.patience.over:
        return stuck
    count = len(base.z)
    new = candidate.start[count:].copy()
    strengths = np.array([not one.shape for one in stuck.unknowns.all[count:]])
    strongest = float(np.abs(new[strengths]).max())
    if strongest == 0.0:
        return stuck
    new[strengths] *= max(1.0, USUAL_Z / strongest)
    return begun_again(engine, base, stuck, stuck.unknowns, np.concatenate([base.z, new]))


def begun_again(engine: Engine, base: Fit, found: Fit, unknowns: Unknowns, z: np.ndarray) -> Fit:
    """`found`, or what a search from `z` (P,) ends with where that is better; one that no simulation follows is not."""
    try:
        again = fit(engine, unknowns, z, found.names, temper=base.temper, most=STEPS)
    except NotConverged:
        return found
    return again if again.cost < found.cost else found
