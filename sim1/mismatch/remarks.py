"""What a verdict has to say besides, in words: what could not be computed, and where a figure tests less than it seems to."""

from collections.abc import Iterator, Sequence

from sim1.mismatch.fit import Fit
from sim1.mismatch.foretold import Foretold
from sim1.mismatch.judging import Judgement
from sim1.mismatch.rounds import Rounds
from sim1.mismatch.thresholds import Thresholds
from sim1.recording.unspread import UNITS

STATED = (*UNITS, "poisson", "friction")  # coefficients of which a bundle says how well they are known
FAR_Z = 3.0  # of their spreads, once in 370 by chance


def not_foretold(foretold: dict[str, Foretold]) -> Iterator[str]:
    """Recordings that no simulation follows, of what `baseline` and `augmented` foretell."""
    for label, what in (("baseline", "the calibrated baseline"), ("augmented", "the model")):
        if label == "augmented" and foretold[label] is foretold["baseline"]:
            return
        for name, why in foretold[label].lost.items():
            yield f"{name} cannot be foretold with {what} from rest and drives alone, so that its errors are not known: {why}"


def not_asked(terms: Sequence[str], why: str) -> str:
    """Effects of which motion held out says nothing."""
    return f"motion held out says nothing for or against {' with '.join(terms)}, whose verdict rests on what was fitted: {why}"


def not_set_apart(name: str) -> str:
    """An effect beside which nothing was foretold that lacks it alone."""
    return f"what {name} adds on motion held out is not known: no model without it was fitted and foretold to the end"


def not_followed(terms: Sequence[str]) -> str:
    """Effects, together where several, that were worth a fit and could not be fitted."""
    return f"{' with '.join(terms)} is judged by nothing: no simulation with {'both' if len(terms) > 1 else 'it'} found its way to the end"


def not_sharpened(why: str) -> str:
    """A contest in which the errors of mesh and step could not be measured where the best model is."""
    return f"what mesh and step get wrong is known beside the baseline alone, as no simulation follows beside the best model: {why}"


def off_priors(fit: Fit) -> Iterator[str]:
    """What was stated of the fabric and the table, and is far from what the recordings ask for."""
    for one, z in zip(fit.unknowns.nominal, fit.nominal_z, strict=True):
        if one.name in STATED and abs(z) >= FAR_Z:
            yield (
                f"{one.name} comes out as {one.value(float(z)):.3g}, where the bundle states {one.centre:.3g}: {abs(z):.1f} of its stated "
                "spreads away; either that statement is wrong, or this does the work of something that is not in the model"
            )


def vote(heldout: Sequence[str], judged: Judgement) -> str:
    """Whether the recordings that no fit saw had a vote on the verdict, and what became of it: what the error on them is worth."""
    where = f"{', '.join(heldout)}, which no fit saw,"
    sides = (("for", judged.spoken_for), ("against", judged.withdrawn))
    decided = [f"{side} {' and '.join(names)}" for side, names in sides if names]
    if not decided and judged.decision.verdict != judged.by_fits.verdict:
        decided.append(f"for {judged.decision.verdict} in place of {judged.by_fits.verdict}")
    if decided:
        return f"{where} had a vote and decided {', '.join(decided)}: the error there is of a model that it helped to choose"
    if judged.asked:
        return f"{where} had a vote on {' and '.join(judged.asked)} and changed nothing: the error there is of a model that it could have changed"
    return f"{where} had no vote: the error there is of a model that was chosen without it"


def by_others(judged: Judgement) -> Iterator[str]:
    """What a recording says that was left out as motion held out said too little for a name."""
    if (one := judged.by_others) is None:
        return
    silent = f"motion held out says too little for {' with '.join(one.terms)}"
    if one.against is None:
        yield f"{silent}, and {one.recording}, which it gains most in, could not be foretold by what the others teach: {one.unasked}"
    else:
        likelier = f"{abs(one.against):.0f} nats {'less likely' if one.against > 0 else 'likelier'}"
        yield (
            f"{silent}: by what all recordings but {one.recording} teach, that one is {likelier} with it than without, "
            f"{'which is enough' if one.speaks else 'which is not enough for a name of its worth'}"
        )


def explains_heldout(found: Rounds, thresholds: Thresholds) -> Iterator[str]:
    """Whether what no fit saw is explained, where it is not or was not at first."""
    if (first := found.taught_by) is not None:
        yield (
            f"{', '.join(first.heldout)}, held out at first, was left at {first.left:.1f} times its variance by what explained the others: "
            f"it was fitted, too, and {', '.join(found.last.heldout)} held out in its place"
        )
    where = f"{', '.join(found.last.heldout)}, which no fit saw,"
    if found.last.unexplained(thresholds):
        untaught = f"; a search that fits it, too, came to no end ({found.not_taught})" if found.not_taught else ""
        yield (
            f"{where} is left at {found.last.left:.1f} times its variance: something shows there that the verdict, said of what was "
            f"fitted, does not explain{untaught}"
        )
    elif found.last.not_left:
        yield f"whether {where} is explained is not known: {found.last.not_left}"
