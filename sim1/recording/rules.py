"""What a rule over the figures of a bundle is, and what it says; the rules themselves are rows of `rule_table.py`."""

from collections.abc import Iterable
from dataclasses import dataclass

from sim1.recording.overall import Overall


@dataclass(frozen=True, kw_only=True)
class Rule:
    """`figure` at or above `least` means that the effects can be told; texts are formatted with all figures."""

    effects: tuple[str, ...]  # names of a verdict; empty: quality of the recordings as a whole
    figure: str
    least: float
    can: str
    cannot: str
    record: str  # remedy
    asked: str | None = None  # only where this figure is above 0


@dataclass(frozen=True, kw_only=True)
class Statement:
    """What one rule says of a bundle."""

    effects: tuple[str, ...]
    can: bool
    text: str
    record: str  # empty where nothing is wanting


def statements(figures: Overall, rules: Iterable[Rule]) -> list[Statement]:
    """What the rules say of a bundle with these figures, in their order."""
    return [_say(rule, figures) for rule in rules if rule.asked is None or (figures[rule.asked] or 0) > 0]


def _say(rule: Rule, figures: Overall) -> Statement:
    value = figures[rule.figure]
    if value is None and rule.figure != "density_known":
        text = f"{' vs '.join(rule.effects) or rule.figure}: cannot be measured here (markers too few or in a line, or a mesh without `vt`)"
        return Statement(effects=rule.effects, can=False, text=text, record=rule.record)
    can = value is not None and value >= rule.least
    shown = {name: float("nan") if figure is None else figure for name, figure in figures.items()}
    text = (rule.can if can else rule.cannot).format(**shown)
    return Statement(effects=rule.effects, can=can, text=text, record="" if can else rule.record)
