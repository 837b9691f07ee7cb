"""What the cases of a proof come to together."""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.stats import binomtest

from sim1.clustered_share import clustered_interval
from sim1.mismatch.strict_json import Strict
from sim1.proof.draw import Strength
from sim1.proof.errors import effect_errors, relative_error
from sim1.proof.outcome import Outcome, or_infinite

WORSE = 0.02  # of the baseline's error: a rise beyond it is told
STRENGTHS: tuple[Strength, ...] = ("weak", "medium", "strong")
NAMELESS = ("none", "unknown", "ambiguous", "failed")  # columns of the confusion matrix that are no names


class Share(Strict):
    """So many of so many, with the 95 % interval of the probability: exact of cases (Clopper and Pearson), by case of coefficients."""

    count: int
    of: int
    low: float | None  # None: what is counted was not drawn, so that there is no such probability
    high: float | None


class Extreme(Strict):
    """The case in which held-out motion got worst by what was added."""

    case: str
    before_mm: float
    after_mm: float


class OfStrength(Strict):
    """Cases of one effect of the table, of one strength."""

    named: Share  # right and alone
    first_ranked: Share  # came first in the ranking, whatever the verdict
    called_none: int
    called_unknown: int  # or ambiguous
    wrong_name: int  # named, and anything else beside or in place of it
    failed: int


class Totals(Strict):
    """All cases together; a share counts cases that failed as wrong. Weak single effects, below what should be found, count where it is said."""

    named: Share  # cases of one effect of the table, medium and strong, named right and alone
    named_as_asked: Share  # the same of those that came out as strong as asked for
    by_strength: dict[Strength, OfStrength]  # cases of one effect of the table, the weak ones too
    effects_ever_named: (
        Share  # different effects of the table that were concealed alone, not weak, and named at least once
    )
    nulls_called_none: Share
    nulls_with_names: Share  # verdict named or ambiguous, with nothing concealed
    false_names: dict[str, int]  # among nulls: effect -> how often
    outside_without_name: Share  # called unknown or ambiguous
    outside_ambiguous: Share  # of these, called ambiguous: that lists names, none of them alone
    several_named: Share  # cases of two effects or more, all named and no other
    several_as_asked: Share  # the first of these two among cases in which each effect came out as strong as asked for
    several_partly: Share  # at least one of them, and none that was not concealed; holds the row above
    named_above_limit: Share  # of single effects, the weak ones too, at least as strong as the diagnosis asks for
    named_below_limit: Share
    first_ranked: Share  # single effects, medium and strong, that came first in the ranking, whatever the verdict
    effect_intervals: Share  # that hold the true coefficient
    effect_error: (
        float | None
    )  # median of how far off, over how far the truth departs from nothing, the largest of the effect in the same unit
    fabric_intervals: Share
    fabric_error: float | None
    place_auc: (
        float | None
    )  # median, where force is local, weak single effects aside: of what does not show springs tell no place
    gap_closed: float | None  # median share of the oracle's gain held out; None: of no case known
    gaps: int  # cases, weak single effects aside, in which there was one to close
    heldout_worse: tuple[str, ...]  # cases, whatever was concealed, in which that error rose by more than `WORSE`, or:
    heldout_lost: tuple[str, ...]  # in which no simulation follows with what was added; infinitely far off in medians
    unseen_ratio: (
        float | None
    )  # the same motions' error after over before, median where effects of the table were concealed, weak single ones aside
    unseen_cases: int
    unseen_gap_closed: float | None
    unseen_gaps: int
    unseen_worse: tuple[str, ...]  # as `heldout_worse`
    unseen_lost: tuple[str, ...]  # as `heldout_lost`
    worst_heldout: Extreme | None  # of those that are simulated; None: it got worse nowhere
    median_seconds: float | None
    failed: int


class Confusion(Strict):
    """How often what was concealed (rows) was called what (columns)."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    counts: tuple[tuple[int, ...], ...]


def share_of(hits: Iterable[bool]) -> Share:
    """Count, with its interval; 0 to 1 where nothing was tried."""
    flags = [bool(hit) for hit in hits]
    if not flags:
        return Share(count=0, of=0, low=0.0, high=1.0)
    interval = binomtest(sum(flags), len(flags)).proportion_ci(0.95, method="exact")
    return Share(count=sum(flags), of=len(flags), low=float(interval.low), high=float(interval.high))


def share_by_case(cases: Iterable[Sequence[bool]]) -> Share:
    """Count coefficients, of which one fit gives several: they hold or fail together, so that the interval is of cases that differ."""
    tried = [case for case in cases if len(case)]
    hits, of = [sum(case) for case in tried], [len(case) for case in tried]
    interval = clustered_interval(hits, of)
    return Share(count=sum(hits), of=sum(of), low=float(interval.low), high=float(interval.high))


def totals_of(outcomes: Sequence[Outcome]) -> Totals:
    """Count what was right, and measure how far off it was."""
    kinds = {kind: [o for o in outcomes if o.kind == kind] for kind in ("null", "outside", "several", "single")}
    nulls, every_single, several = kinds["null"], kinds["single"], kinds["several"]
    singles = [o for o in every_single if not o.weak]
    finds = [o.found for o in outcomes if o.found]
    effects = [[n for part in one.effects.values() for n in part.values() if n.true is not None] for one in finds]
    fabric = [list(one.fabric.values()) for one in finds]
    places = [o.found.place_auc for o in outcomes if o.found and o.found.place_auc is not None and not o.weak]
    gaps = [one.gap_closed for one in outcomes if one.gap_closed is not None and not one.weak]
    unseen = [(o.unseen_mm[0], or_infinite(o.unseen_mm[1])) for o in (*singles, *several) if _known(o.unseen_mm)]
    unseen_gaps = [one.unseen_gap_closed for one in outcomes if one.unseen_gap_closed is not None and not one.weak]
    named_nulls = [o for o in nulls if o.named]
    false = [name for o in named_nulls for name in o.named]
    return Totals(
        named=share_of(o.right for o in singles),
        named_as_asked=share_of(o.right for o in singles if o.as_asked),
        by_strength={name: _of_strength([o for o in every_single if o.strength == name]) for name in STRENGTHS},
        effects_ever_named=_ever_named(singles),
        nulls_called_none=share_of(o.right for o in nulls),
        nulls_with_names=share_of(o in named_nulls for o in nulls),
        false_names={name: false.count(name) for name in sorted(set(false))},
        outside_without_name=share_of(o.right for o in kinds["outside"]),
        outside_ambiguous=share_of(o.verdict == "ambiguous" for o in kinds["outside"]),
        several_named=share_of(o.right for o in several),
        several_as_asked=share_of(o.right for o in several if o.as_asked),
        several_partly=share_of(o.verdict == "named" and set(o.named) <= set(o.concealed) for o in several),
        named_above_limit=share_of(o.right for o in every_single if _over(o, least=1.0)),
        named_below_limit=share_of(o.right for o in every_single if _over(o, most=1.0)),
        first_ranked=_first_ranked(singles),
        effect_intervals=share_by_case([n.holds for n in numbers] for numbers in effects),
        effect_error=median(
            [off for one in finds for name, part in one.effects.items() for off in effect_errors(name, part)]
        ),
        fabric_intervals=share_by_case([n.holds for n in numbers] for numbers in fabric),
        fabric_error=median([off for numbers in fabric for n in numbers for off in relative_error(n)]),
        place_auc=median(places),
        gap_closed=median(gaps),
        gaps=len(gaps),
        heldout_worse=tuple(o.case for o in outcomes if o.found and _worse(o.found.heldout_mm)),
        heldout_lost=tuple(o.case for o in outcomes if o.heldout_lost),
        unseen_ratio=median([after / before for before, after in unseen]),
        unseen_cases=len(unseen),
        unseen_gap_closed=median(unseen_gaps),
        unseen_gaps=len(unseen_gaps),
        unseen_worse=tuple(o.case for o in outcomes if _worse(o.unseen_mm)),
        unseen_lost=tuple(o.case for o in outcomes if o.unseen_lost),
        worst_heldout=_worst(outcomes),
        median_seconds=median([o.seconds for o in outcomes]),
        failed=sum(o.verdict == "failed" for o in outcomes),
    )


def _of_strength(singles: Sequence[Outcome]) -> OfStrength:
    said = [o.verdict for o in singles]
    return OfStrength(
        named=share_of(o.right for o in singles),
        first_ranked=_first_ranked(singles),
        called_none=said.count("none"),
        called_unknown=said.count("unknown") + said.count("ambiguous"),
        wrong_name=sum(o.verdict == "named" and not o.right for o in singles),
        failed=said.count("failed"),
    )


def _first_ranked(singles: Sequence[Outcome]) -> Share:
    return share_of(o.found is not None and o.found.first in o.concealed for o in singles)


def _ever_named(singles: Sequence[Outcome]) -> Share:
    """Of the effects that were concealed alone; which these are the draw of few cases decides, and no probability."""
    right = [any(o.right for o in singles if name in o.concealed) for name in {n for o in singles for n in o.concealed}]
    return Share(count=sum(right), of=len(right), low=None, high=None)


type Errors = tuple[float | None, float | None]  # before and after what was added; None: no simulation


def _known(errors: Errors | None) -> bool:
    """Whether there is something to compare with."""
    return errors is not None and errors[0] is not None


def _worse(errors: Errors | None) -> bool:
    if not _known(errors):
        return False
    before, after = errors
    return or_infinite(after) > (1.0 + WORSE) * before


def _over(outcome: Outcome, least: float = 0.0, most: float = np.inf) -> bool:
    """Whether a single effect's strength lies in that range of its limit; one whose limit is not known lies in none."""
    return outcome.found is not None and any(least <= over < most for over in outcome.found.over_limit.values())


def confusion_of(outcomes: Sequence[Outcome]) -> Confusion:
    """Rows: none, single effects, several, outside; columns: verdicts without a name, then names."""
    order = ("null", "single", "several", "outside")
    cells = [((order.index(o.kind), _joined(o.concealed) or "none"), _called(o)) for o in outcomes]
    rows = sorted({row for row, _ in cells})
    names = [row for _, row in rows if row != "none"]
    others = sorted({column for _, column in cells} - set(names) - set(NAMELESS))
    columns = [*NAMELESS, *(name for name in names if any(column == name for _, column in cells)), *others]
    return Confusion(
        rows=tuple(name for _, name in rows),
        columns=tuple(columns),
        counts=tuple(tuple(cells.count((row, column)) for column in columns) for row in rows),
    )


def _called(outcome: Outcome) -> str:
    return _joined(outcome.named) if outcome.verdict == "named" else outcome.verdict


def _joined(names: Iterable[str]) -> str:
    return " + ".join(sorted(names))


def median(values: Sequence[float]) -> float | None:
    """None: of nothing, or as many as half are infinitely far off."""
    middle = float(np.median(values)) if values else np.inf
    return middle if np.isfinite(middle) else None


def _worst(outcomes: Sequence[Outcome]) -> Extreme | None:
    known = [o for o in outcomes if o.found and None not in o.found.heldout_mm]
    cases = [(o.found.heldout_mm[1] - o.found.heldout_mm[0], o) for o in known]
    worse, outcome = max(cases, key=lambda item: item[0], default=(0.0, None))
    if worse <= 0 or outcome is None:
        return None
    before, after = outcome.found.heldout_mm
    return Extreme(case=outcome.case, before_mm=before, after_mm=after)
