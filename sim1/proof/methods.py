"""The diagnosis beside simpler methods, a row each: what is the whole of it worth against a part, a count or a guess?"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from sim1.mismatch.strict_json import Strict
from sim1.proof.outcome import Outcome, is_right, or_infinite
from sim1.proof.totals import Share, median, share_of

WITHOUT = {"null": "none", "outside": "unknown"}  # the right answers that are no names


class Method(Strict):
    """What a method comes to in the cases that it was asked."""

    name: str
    cases: int
    singles: Share | None  # medium and strong, named right and alone; None in the first four: it gives no names
    nulls: Share | None  # called none
    outside: Share | None  # without a name, and not called none
    several: Share | None  # all named and no other
    heldout: (
        float | None
    )  # median of its error over that of parameters alone, where effects of the table were concealed, weak single ones aside
    heldout_cases: int
    lost: int  # of these: no simulation with what it adds finds its way, infinitely far off in the medians
    gap_closed: float | None  # median share of the oracle's gain
    gaps: int
    seconds: float | None  # median


@dataclass(frozen=True, kw_only=True)
class Said:
    """A method's answer to a case."""

    verdict: str | None  # None: it gives no names
    named: tuple[str, ...] = ()
    heldout_mm: float | None = None  # None: it gives no model; infinite: no simulation of it found its way
    seconds: float | None = None


def methods_of(outcomes: Sequence[Outcome]) -> tuple[Method, ...]:
    """A row for each method that was asked; where simulations of a method failed, there is an answer without an error."""
    answer, name = commonest(outcomes)
    rows = {
        "the diagnosis": _diagnosis,
        "sparse regression on forces (SINDy)": _sindy,
        "a residual of 18 numbers, without a name": _residual,
        "the least misfit of the ranking": _least_misfit,
        f"always the commonest answer ({_written(answer)})": lambda one: _called(answer),
        f"always the commonest name ({_written(name)})": lambda one: _called(name),
        "parameters alone": _parameters,
        "the oracle, which is told the effects": _oracle,
    }
    return tuple(_row(label, outcomes, rule) for label, rule in rows.items())


def commonest(outcomes: Sequence[Outcome]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The commonest right answer, and the commonest effect of the table, of cases that count; of several, the first by alphabet."""
    counted = [one for one in outcomes if not one.weak]
    answers = Counter((WITHOUT[o.kind],) if o.kind in WITHOUT else tuple(sorted(o.concealed)) for o in counted)
    names = Counter((effect,) for o in counted if o.kind not in WITHOUT for effect in o.concealed)
    return _most(answers), _most(names)


def _most(counts: Counter) -> tuple[str, ...]:
    return min(counts, key=lambda item: (-counts[item], item), default=("none",))


def _called(answer: tuple[str, ...]) -> Said:
    if answer[0] in WITHOUT.values():
        return Said(verdict=answer[0])
    return Said(verdict="named", named=answer)


def _written(answer: tuple[str, ...]) -> str:
    return " + ".join(answer)


def _named(names: tuple[str, ...], **rest: float | None) -> Said:
    return Said(verdict="named" if names else "none", named=names, **rest)


def _diagnosis(one: Outcome) -> Said:
    after = or_infinite(one.found.heldout_mm[1]) if one.found else None
    return Said(verdict=one.verdict, named=one.named, heldout_mm=after, seconds=one.seconds)


def _sindy(one: Outcome) -> Said | None:
    said = one.baselines.sindy if one.baselines else None
    if said is None:
        return None
    if said.named is None:
        return Said(verdict="failed", seconds=said.seconds)
    return _named(said.named, heldout_mm=or_infinite(said.heldout_mm), seconds=said.seconds)


def _residual(one: Outcome) -> Said | None:
    said = one.baselines.residual if one.baselines else None
    return said and Said(verdict=None, heldout_mm=or_infinite(said.heldout_mm), seconds=said.seconds)


def _least_misfit(one: Outcome) -> Said:
    return Said(verdict="failed") if one.found is None else _named(one.found.least_misfit)


def _parameters(one: Outcome) -> Said | None:
    return Said(verdict=None, heldout_mm=one.found.heldout_mm[0]) if one.found else None


def _oracle(one: Outcome) -> Said | None:
    if one.oracle_s is None:
        return None
    return Said(verdict=None, heldout_mm=or_infinite(one.oracle_mm), seconds=one.oracle_s)


def _row(label: str, outcomes: Sequence[Outcome], rule) -> Method:
    said = [(one, answer) for one in outcomes if (answer := rule(one)) is not None]
    moved = [
        (one, answer.heldout_mm)
        for one, answer in said
        if one.kind not in WITHOUT
        and not one.weak
        and one.found
        and one.found.heldout_mm[0] is not None
        and answer.heldout_mm is not None
    ]
    gaps = [gap for one, after in moved if (gap := one.gap_closed_by(after)) is not None]
    return Method(
        name=label,
        cases=len(said),
        singles=_right("single", said),
        nulls=_right("null", said),
        outside=_right("outside", said),
        several=_right("several", said),
        heldout=median([after / one.found.heldout_mm[0] for one, after in moved]),
        heldout_cases=len(moved),
        lost=sum(after == math.inf for _, after in moved),
        gap_closed=median(gaps),
        gaps=len(gaps),
        seconds=median([answer.seconds for _, answer in said if answer.seconds is not None]),
    )


def _right(kind: Literal["null", "outside", "several", "single"], said: Sequence[tuple[Outcome, Said]]) -> Share | None:
    if any(answer.verdict is None for _, answer in said):
        return None
    return share_of(
        is_right(kind, tuple(one.concealed), answer.verdict, answer.named)
        for one, answer in said
        if one.kind == kind and not one.weak
    )
