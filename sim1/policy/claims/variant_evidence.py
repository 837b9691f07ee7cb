"""What variants of the graph say to claims of what each part is worth."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from sim1.clustered_share import Difference
from sim1.policy.claims.evidence import Evidence, Finder, nothing_of
from sim1.policy.claims.verdict import Measured, Missing
from sim1.policy.counting import percentage_points, rate
from sim1.statistics import Interval, difference_interval, wilson_interval

# How many of how many, and its interval; None: of trials that are independent.
type Side = tuple[int, int, Interval | None]


def pass_rate(variant: str) -> Finder:
    """Attempts of a variant that all filters accept."""

    def find(known: Evidence) -> Measured | Missing:
        if isinstance(row := _row(known, variant), Missing):
            return row
        count, total = row["accepted_count"], row["candidate_count"]
        return Measured(shown=f"{rate(count, total)} (%)", interval=wilson_interval(count, total))

    return find


def pass_over(variant: str, other: str) -> Finder:
    """Pass rate of a variant minus that of another."""
    return _over(variant, other, _row, lambda row: (row["accepted_count"], row["candidate_count"], None))


def policy_success(variant: str) -> Finder:
    """Success of the policy of a variant, all shifts that were tried together."""

    def find(known: Evidence) -> Measured | Missing:
        if isinstance(row := _tried_row(known, variant), Missing):
            return row
        tried = row["all_trials"]
        counts = tried["success_count"], tried["trial_count"]
        shifts = ", ".join(one["shift"] for one in row["shifts"])
        return Measured(
            shown=f"{rate(*counts, Interval(*tried['interval']))} (%)",
            interval=Interval(*tried["interval"]),
            remark=f"shifts: {shifts}",
        )

    return find


def policy_over(variant: str, other: str) -> Finder:
    """Success of the policy of a variant minus that of another."""

    def side(row: Mapping[str, Any]) -> Side:
        tried = row["all_trials"]
        return tried["success_count"], tried["trial_count"], Interval(*tried["interval"])

    return _over(variant, other, _tried_row, side)


def base_over(variant: str) -> Finder:
    """Success of the base's policy minus that of a variant's, over pairs from the same placements in the stand-in reality."""

    def find(known: Evidence) -> Measured | Missing:
        if isinstance(row := _tried_row(known, variant), Missing):
            return row
        if not row["over_base"]:
            return Missing(why=f"{variant} and base have no placement in the stand-in reality in common")
        found = row["over_base"]
        low, high = found["interval"]
        turned = Difference(pair_count=found["pair_count"], value=-found["value"], interval=Interval(-high, -low))
        return Measured(shown=f"{percentage_points(turned)} (points)", interval=turned.interval)

    return find


def _over(
    variant: str,
    other: str,
    row_of: Callable[[Evidence, str], Mapping[str, Any] | Missing],
    side: Callable[[Mapping[str, Any]], Side],
) -> Finder:
    """A variant's share minus another's, which are no pairs; `row_of` finds their rows, `side` what is compared."""

    def find(known: Evidence) -> Measured | Missing:
        rows = [row_of(known, name) for name in (variant, other)]
        if missing := [row.why for row in rows if isinstance(row, Missing)]:
            return Missing(why="; ".join(dict.fromkeys(missing)))
        return _apart([side(row) for row in rows])

    return find


def _apart(sides: Sequence[Side]) -> Measured:
    """Of two shares that are no pairs, by Newcombe's interval; without an interval of its own, a side has Wilson's."""
    (one, other), counts = ((won / of, interval or wilson_interval(won, of)) for won, of, interval in sides), sides
    found = difference_interval(one, other)
    value, (low, high) = one[0] - other[0], found
    against = " against ".join(f"{won} of {of}" for won, of, _ in counts)
    return Measured(
        shown=f"{100 * value:+.0f} ({100 * low:+.0f} to {100 * high:+.0f}) (points), {against}", interval=found
    )


def _row(known: Evidence, variant: str) -> Mapping[str, Any] | Missing:
    if known.ablation is None:
        return nothing_of(known, "ablation_report")
    row = known.ablation.get(variant)
    if row is None or not row["candidate_count"]:
        return Missing(why=f"variant {variant} was not made")
    return row


def _tried_row(known: Evidence, variant: str) -> Mapping[str, Any] | Missing:
    row = _row(known, variant)
    if isinstance(row, Missing) or row["all_trials"]:
        return row
    return Missing(why=f"variant {variant} has no policy that was tried")
