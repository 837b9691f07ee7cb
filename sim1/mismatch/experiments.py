"""Which recording would settle what a verdict leaves open, or put a name to the test that others can imitate."""

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.apart import apart
from sim1.mismatch.decide import rating
from sim1.mismatch.diagnose import Diagnosis
from sim1.mismatch.excess import mean_square, worst_recording
from sim1.mismatch.models import Model
from sim1.mismatch.ranked import joined
from sim1.mismatch.separating import SEPARATING
from sim1.mismatch.summary import Undecided
from sim1.mismatch.thresholds import THRESHOLDS


def next_experiment(found: Diagnosis) -> str:
    """One sentence: what to record next."""
    left = left_open(found)
    return left.record if left else "none needed for this difference"


def left_open(found: Diagnosis) -> Undecided | None:
    """What the verdict itself leaves open and what would settle it; None: nothing."""
    if found.stopped:
        return Undecided(
            what="what was not tried",
            record="the search was stopped before all was tried: diagnose again with more time",
        )
    if found.verdict == "ambiguous":
        return _of_two(found.chosen, min(found.rivals, key=rating))
    if found.verdict == "unknown" or found.misfit["chosen"] > THRESHOLDS.misfit:
        return _of_what_is_left(found.chosen)
    tests = [(name, test) for name in found.chosen.terms if (test := EFFECTS[name].testing)]
    if not tests:
        return None
    name, test = tests[0]
    return Undecided(what=f"whether it is {name}, which others can imitate", record=f"none needed; to be sure, {test}")


def _of_two(chosen: Model, rival: Model) -> Undecided:
    """The chosen model and its closest rival: the recording in which they differ most, and what to vary in it."""
    first, *others = apart(chosen.fit, rival.fit)
    elsewhere = ", ".join(f"{row.noises:.2g} in {row.recording}" for row in others)
    return Undecided(
        what=f"whether it is {joined(chosen)} or {joined(rival)}",
        record=f"repeat {first.recording}, in which {joined(chosen)} and {joined(rival)} differ most ({first.noises:.2g} times noise and mesh "
        f"error{f'; {elsewhere}' if others else ''}), and vary it: {_varied(chosen, rival)}",
    )


def _varied(chosen: Model, rival: Model) -> str:
    """What tells the effects that one of the two models has from those that the other has."""
    own = [name for name in chosen.terms if name not in rival.terms]
    other = [name for name in rival.terms if name not in chosen.terms]
    pairs = [frozenset((one, two)) for one in own for two in other]
    known = [SEPARATING[pair] for pair in pairs if pair in SEPARATING]
    return "; ".join(known or [EFFECTS[name].varied for name in (*own, *other)])


def _of_what_is_left(chosen: Model) -> Undecided:
    """What no effect explains: the recording in which most of it is left."""
    name = worst_recording(chosen.fit)
    left = mean_square(chosen.fit, (name,))
    return Undecided(
        what=f"what is left beside {joined(chosen)}",
        record=f"repeat {name}, which is explained worst (mean square {left:.1f} times what noise and mesh explain), slower, and once held still "
        "after it: what vanishes tells speed from stiffness and slip",
    )
