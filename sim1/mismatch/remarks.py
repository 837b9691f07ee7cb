"""What a verdict has to say besides, in words: what could not be computed, and where a figure tests less than it seems to."""

from collections.abc import Iterator, Sequence

from sim1.mismatch.foretold import Foretold


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


def had_a_say(heldout: Sequence[str], spoken_for: Sequence[str], withdrawn: Sequence[str]) -> Iterator[str]:
    """Where the recordings that no fit saw changed what is named: the error on them is then of a model that they helped to choose."""
    where = ", ".join(heldout)
    for names, did in ((spoken_for, "for"), (withdrawn, "against")):
        if names:
            yield f"{where}, which no fit saw, decided {did} {' and '.join(names)}: the error there is of a model that it helped to choose"
