"""What the ranking of a diagnosis and its own limits say of a case."""

import math
from collections.abc import Mapping

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.summary import Summary

BASELINE = "the baseline"  # what a ranking calls the model without effects
JOINT = " with "  # between the effects of a ranked model


def over_limit(summary: Summary, effect: str, given: Mapping[str, float]) -> float | None:
    """How strong a concealed effect is, in units of the strength from which the diagnosis foretold that it would show.

    `given` holds its parameters as they are published, from which the coefficients that are searched follow where all are there. Several strengths count by the root of their squares' sum, as they add to what is gained; factors by their logarithms; one that
    shows at no strength counts nothing. None: the answers hold no coefficient of which a limit was asked.
    """
    parts = []
    if effect in EFFECTS and set(EFFECTS[effect].units()) <= set(given):
        given = EFFECTS[effect].searched(dict(given))
    for row in summary.detectable:
        if row.effect == effect and row.coefficient in given:
            there = given[row.coefficient]
            if row.least is None:
                parts.append(0.0)
            elif row.absent > 0.0:
                parts.append(math.log(there / row.absent) / math.log(row.least / row.absent))
            else:
                parts.append((there - row.absent) / (row.least - row.absent))
    return math.hypot(*parts) if parts else None


def first_single(summary: Summary) -> str | None:
    """The best of the ranked models with one effect."""
    singles = [row for row in summary.ranking if row.name != BASELINE and JOINT not in row.name]
    return max(singles, key=lambda row: row.gain).name if singles else None


def least_misfit(summary: Summary) -> tuple[str, ...]:
    """Effects of the ranked model with the least misfit on what was fitted: what plain error would name."""
    best = min(summary.ranking, key=lambda row: row.misfit, default=None)
    return () if best is None or best.name == BASELINE else tuple(sorted(best.name.split(JOINT)))
