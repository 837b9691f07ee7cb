"""How strong an effect must be for these recordings to show it: what a verdict that does not name it is worth.

The fingerprints of the screening tell how the markers would move, what the baseline can imitate taken out. An effect of strength z
then gains z^2 P / 2 nats in the mean, with P the curvature that is left, less what Laplace's evidence and the search charge for it
(expected gain of a likelihood ratio, noncentral chi square; Wald 1943).
"""

import math
from dataclasses import dataclass

from sim1.mismatch.screen import Candidate
from sim1.mismatch.thresholds import Thresholds

FAR = 3.0  # typical strengths: a linear forecast is trusted no farther


@dataclass(frozen=True, kw_only=True)
class Detectable:
    """One strength of an effect, the others at nothing."""

    effect: str
    coefficient: str
    unit: str
    absent: float  # value at which the effect is not there
    least: float | None  # value from which it would be named; None: not within its limits or three typical strengths


def detectable(screened: tuple[Candidate, ...], thresholds: Thresholds) -> tuple[Detectable, ...]:
    """By effect and strength, names sorted; what the recordings were never asked (no table, no grip) is not there."""
    rows = []
    for candidate in sorted(screened, key=lambda one: one.term.effect.name):
        strengths = [c for c in candidate.term.coefficients if not c.shape]
        for c, information in zip(strengths, candidate.information, strict=True):
            z = _least(information, thresholds.named + thresholds.per_term + math.log(candidate.variants))
            ways = [way for way in (z, -z) if c.low <= c.unlimited(way) <= c.high]
            rows.append(
                Detectable(
                    effect=candidate.term.effect.name,
                    coefficient=c.name,
                    unit=c.unit,
                    absent=c.value(0.0),
                    least=c.value(ways[0]) if ways and z <= FAR else None,
                )
            )
    return tuple(rows)


def _least(information: float, price: float) -> float:
    """The z at which the expected evidence is worth its price."""
    if information <= 0.0:
        return math.inf
    return math.sqrt(2.0 * (price + 0.5 * math.log1p(information)) / information)
