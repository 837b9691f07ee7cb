"""A claim is a band of values; a measurement lies in it, outside of it, or leaves both open."""

import math
from dataclasses import dataclass
from typing import Literal

from sim1.statistics import Interval, wilson_interval

AGREES, DISAGREES, NOT_DECIDED, NOT_RUN = "agrees", "disagrees", "not decided", "not run"
type Verdict = Literal["agrees", "disagrees", "not decided", "not run"]


@dataclass(frozen=True, kw_only=True)
class Band:
    """Values that agree with a claim, both ends included."""

    low: float
    high: float
    words: str  # the same for a person


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What a run says to a claim."""

    shown: str  # value, interval and count, for a person
    interval: (
        Interval | None
    )  # in the unit of the band; an end that is not known is infinite; None: nothing is known of the value
    remark: str = ""  # what else has to be known of it


@dataclass(frozen=True, kw_only=True)
class Missing:
    """Nothing was measured."""

    why: str


def verdict(found: Measured | Missing, band: Band) -> Verdict:
    """By the interval alone: all of it inside, all of it outside, or some of either."""
    if isinstance(found, Missing):
        return NOT_RUN
    if found.interval is None:
        return NOT_DECIDED
    low, high = found.interval
    if band.low <= low and high <= band.high:
        return AGREES
    return DISAGREES if high < band.low or low > band.high else NOT_DECIDED


def about(value: float, factor: float) -> Band:
    """No more than so many times more or less."""
    low, high = value / factor, value * factor
    return Band(
        low=low,
        high=high,
        words=f"{low:g} to {high:g}: the paper gives no interval, a factor of {factor:g} is let pass",
    )


def near(value: float, margin: float, unit: str = "") -> Band:
    """No more than a margin away."""
    return Band(low=value - margin, high=value + margin, words=f"{value:g} ± {margin:g}{unit}")


def more_than_nothing() -> Band:
    """A difference, or a slope, that is greater than zero."""
    return Band(low=math.ulp(0.0), high=math.inf, words="more than 0")


def at_least(value: float, unit: str) -> Band:
    """So much or more."""
    return Band(low=value, high=math.inf, words=f"at least {value:g} {unit}")


def at_most(value: float, unit: str) -> Band:
    """So much or less."""
    return Band(low=-math.inf, high=value, words=f"at most {value:g} {unit}")


def pass_share(percent: int, margin: int = 10) -> Band:
    """A share of attempts of which the paper prints no count."""
    low, high = max(0, percent - margin), min(100, percent + margin)
    words = f"{low} to {high} %: the paper prints no count, {margin} points are let pass"
    return Band(low=low / 100, high=high / 100, words=words)


def success_share(percent: int, trials: int) -> Band:
    """A success rate, within the 95 % interval that the paper's own trials leave open."""
    low, high = wilson_interval(round(percent * trials / 100), trials)
    words = f"{100 * low:.0f} to {100 * high:.0f} %, which the paper's {trials} trials leave open"
    return Band(low=low, high=high, words=words)


def success_of(percent: int, trials: int) -> Band:
    """The same or better."""
    low, _ = wilson_interval(round(percent * trials / 100), trials)
    return Band(
        low=low,
        high=1.0,
        words=f"at least {100 * low:.0f} %, the lower end of what the paper's {trials} trials leave open",
    )
