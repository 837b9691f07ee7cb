"""What generated motion is held to, and whether it keeps to it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sim1.motion.likeness.comparison import Figure


@dataclass(frozen=True, kw_only=True)
class Limit:
    """Bounds of one figure."""

    figure: str
    low: float | None = None
    high: float | None = None
    words: str  # for a person

    def verdict(self, figure: Figure) -> dict[str, Any]:
        """JSON: the figure, the bounds, and whether they are met; null where nothing was measured."""
        met = None
        if figure.value is not None:
            met = (self.low is None or figure.value >= self.low) and (self.high is None or figure.value <= self.high)
        row = {"figure": self.figure, "low": self.low, "high": self.high, "words": self.words, "met": met}
        return row | {"value": figure.value, "not_measured": figure.missing or None}


LIMITS = (
    Limit(figure="join", high=1.0, words="at most 1.0"),
    Limit(figure="jerk_share", low=1 / 1.5, high=1.5, words="between 1/1.5 and 1.5"),  # smoother is unlike them, too
    Limit(figure="path_share", low=0.95, high=1.1, words="between 0.95 and 1.1"),
    Limit(figure="auc", high=0.7, words="at most 0.7"),
    Limit(figure="copies", high=0.0, words="none"),
)


def verdicts(figures: Mapping[str, Figure]) -> list[dict[str, Any]]:
    """Of every limit, for the figures of one set."""
    return [limit.verdict(figures[limit.figure]) for limit in LIMITS]


def in_words(verdict: Mapping[str, Any]) -> str:
    """A verdict as one line."""
    if verdict["met"] is None:
        return f"not measured: {verdict['not_measured']} (limit {verdict['words']})"
    return f"{verdict['value']:.3g}, limit {verdict['words']}"
