"""Intervals that stand beside every share that the project reports."""

from statistics import NormalDist
from typing import NamedTuple


class Interval(NamedTuple):
    """Limits of a confidence interval, in the unit of the quantity."""

    low: float
    high: float


def wilson_interval(success_count: float, trial_count: float, confidence: float = 0.95) -> Interval:
    """Wilson score interval of a probability; (0, 1) when nothing was tried. Counts may be effective ones, no whole numbers.

    Unlike the normal approximation it stays honest for few trials and for 0 or all successes.
    Source: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209.

    Raises:
        ValueError: counts that cannot be counts, or a confidence outside (0, 1).
    """
    if not 0 <= success_count <= trial_count:
        raise ValueError(f"success_count must lie between 0 and trial_count (got {success_count} of {trial_count})")
    if not 0 < confidence < 1:
        raise ValueError(f"confidence must lie in (0, 1) (got {confidence})")
    if trial_count == 0:
        return Interval(0.0, 1.0)
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    share = success_count / trial_count
    shrink = 1 + z**2 / trial_count
    middle = (share + z**2 / (2 * trial_count)) / shrink
    half = z / shrink * (share * (1 - share) / trial_count + z**2 / (4 * trial_count**2)) ** 0.5
    # The formula gives these limits exactly; floating point would miss them by 1e-17.
    low = 0.0 if success_count == 0 else middle - half
    high = 1.0 if success_count == trial_count else middle + half
    return Interval(low, high)


def difference_interval(
    first: tuple[float, Interval], second: tuple[float, Interval], correlation: float = 0.0
) -> Interval:
    """Interval of the first share minus the second, each given with its own interval; `correlation` is that of the two shares.

    Source: R. G. Newcombe, Stat. Med. 17 (1998) 873, method 10, and 2635, method 10, for paired trials: distances of the limits,
    squared and added.
    """
    (one, own), (other, others) = first, second
    value = one - other
    down = _across(one - own.low, others.high - other, correlation)
    up = _across(own.high - one, other - others.low, correlation)
    return Interval(max(-1.0, value - down), min(1.0, value + up))


def _across(one: float, other: float, correlation: float) -> float:
    return max(0.0, one**2 - 2 * correlation * one * other + other**2) ** 0.5


def describe_share(success_count: int, trial_count: int, interval: Interval | None = None) -> str:
    """A share as people read it: "3 of 10 = 30 % (95 % interval 11 to 60 %)"; without an interval of its own, Wilson's."""
    if trial_count == 0:
        return "none tried"
    low, high = interval or wilson_interval(success_count, trial_count)
    share = 100 * success_count / trial_count
    return f"{success_count} of {trial_count} = {share:.0f} % (95 % interval {100 * low:.0f} to {100 * high:.0f} %)"
