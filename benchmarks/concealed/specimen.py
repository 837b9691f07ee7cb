"""Which cloth is filmed: one on which what is concealed comes out as strong as the case asks, if a few have one among them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.concealed.case import STRENGTHS, Case, Plan
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.film import Stage
from benchmarks.concealed.mesh import Mesh
from benchmarks.concealed.strength import WITHIN, Films

SPECIMENS = 3
"""That are tried: each costs most of what a case costs."""
ENOUGH = float(np.exp(-WITHIN))
"""Of the strength that was asked for: the search is content with it."""


@dataclass(frozen=True, kw_only=True)
class Specimen:
    """A cloth with its motions, before and after something was concealed."""

    case: Case
    """Whose `specimen` says which one it is."""
    stage: Stage
    mesh: Mesh
    """That is handed over."""
    plans: Sequence[Plan]
    without: Films
    """Nothing concealed."""
    effects: Sequence[Effect]
    tracks: Films
    """With the effects, of some of the plans."""
    strengths: Sequence[float]
    """How strong each effect came out, in units of the noise."""

    @property
    def share(self) -> float:
        """Of the strength that was asked for, what the weakest effect has; 1 where nothing is concealed."""
        return min(self.strengths, default=STRENGTHS[self.case.strength]) / STRENGTHS[self.case.strength]


def taken(case: Case, made: Callable[[Case], Specimen]) -> Specimen:
    """The first specimen on which every effect is as strong as asked, within the tolerance of the search; else the one that comes nearest.

    A strain that stiffens cloth moves no marker of a sheet that nothing stretches. Who wants to film a strong effect takes another sheet then,
    other motions with it; nobody has looked for the effect by that time. A weak one is never too weak, and motions that were chosen are those
    of one cloth: what another recording of it adds can be told.
    """
    best = made(case)
    for number in range(1, 1 if case.strength == "weak" or case.motions else SPECIMENS):
        if best.share >= ENOUGH:
            break
        best = max(best, made(replace(case, specimen=number)), key=lambda one: one.share)
    return best
