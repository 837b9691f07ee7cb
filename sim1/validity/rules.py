"""Threshold rules over features: learned, written and applied as data that a person can read.

They are part of an artifact, and one whose bytes were changed is refused: other rules come of other settings.

The paper's authors wrote theirs with a language model's help; here a shallow decision tree proposes them, or, with too few
failures to learn from, the range of the successful runs with a margin.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from sklearn.tree import DecisionTreeClassifier

from sim1.stage import BadInput

SCHEMA = "sim1.rules/1"


@dataclass(frozen=True, kw_only=True)
class Condition:
    """A feature lies between two limits; None is no limit."""

    feature: str
    above: float | None = None
    below: float | None = None

    def holds(self, value: float) -> bool:
        """Whether it does. A feature that is not a number fulfils nothing."""
        inside = (self.above is None or value >= self.above) and (self.below is None or value <= self.below)
        return bool(np.isfinite(value)) and inside

    def __str__(self) -> str:
        low = "" if self.above is None else f"{self.above:.4g} <= "
        high = "" if self.below is None else f" <= {self.below:.4g}"
        return f"{low}{self.feature}{high}"


@dataclass(frozen=True, kw_only=True)
class Rules:
    """An episode is admissible when all conditions of any one alternative hold."""

    method: str  # tree or intervals
    reason: str  # why that method
    any_of: tuple[tuple[Condition, ...], ...]

    def broken(self, features: dict[str, float]) -> list[str]:
        """Conditions that fail, of the alternative that comes nearest; empty when admissible."""
        failing = [
            [f"{condition}, is {features.get(condition.feature, np.nan):.4g}" for condition in alternative
             if not condition.holds(features.get(condition.feature, np.nan))]
            for alternative in self.any_of
        ]  # fmt: skip
        return min(failing, key=len, default=["no alternative at all"])


def learn_rules(
    features: pd.DataFrame,
    success: np.ndarray,
    *,
    depth: int,
    recall_floor: float,
    margin: float,
    minimum_per_class: int,
) -> Rules:
    """Rules from examples (n, features) with their outcome (n,) bool.

    Raises:
        ValueError: there is no successful example.
    """
    good, bad = int(success.sum()), int((~success).sum())
    if good == 0:
        raise ValueError("no successful example to learn admissible ranges from")
    counts = f"{good} successes and {bad} failures"
    if min(good, bad) < minimum_per_class:
        reason = f"{counts}: a tree needs {minimum_per_class} of each, so the range of the successes with a margin"
        return Rules(method="intervals", reason=reason, any_of=(_intervals(features[success], margin),))
    alternatives = _tree_alternatives(features, success, depth, recall_floor)
    return Rules(method="tree", reason=f"{counts}: a tree of depth {depth}", any_of=alternatives)


def _intervals(positives: pd.DataFrame, margin: float) -> tuple[Condition, ...]:
    """Range of the features at the end, and of the stretch on the way, over the successes, widened on both sides.

    Many ranges of few runs would reject everything new; these are the ones that hold whatever the pace of a motion.
    Widened by `margin` of the range, by a tenth of the middle value where few examples vary little, and at least by 0.02.
    """
    conditions = []
    for name, values in positives.items():
        if not (str(name).startswith("end.") or "stretch_p99" in str(name)):
            continue
        low, high = float(values.min()), float(values.max())
        wide = max(margin * (high - low), 0.1 * abs(low + high) / 2, 0.02)
        above = low - wide if low - wide > 0 else None  # no feature is negative
        conditions.append(Condition(feature=str(name), above=above, below=high + wide))
    return tuple(conditions)


def _tree_alternatives(features: pd.DataFrame, success: np.ndarray, depth: int, recall_floor: float) -> tuple[tuple[Condition, ...], ...]:  # fmt: skip
    """Leaves of a decision tree, purest first, until they hold `recall_floor` of the successes."""
    model = DecisionTreeClassifier(max_depth=depth, class_weight="balanced", min_samples_leaf=2, random_state=0)
    model.fit(features.to_numpy(), success)
    leaf = model.apply(features.to_numpy())
    paths = _paths(model.tree_, list(features.columns))
    order = sorted(paths, key=lambda node: (-success[leaf == node].mean(), node))
    chosen, held = [], 0
    for node in order:
        if held >= recall_floor * success.sum():
            break
        chosen.append(paths[node])
        held += int(success[leaf == node].sum())
    return tuple(chosen)


def _paths(tree: Any, names: list[str]) -> dict[int, tuple[Condition, ...]]:
    """Leaf -> conditions on the way to it, one per feature."""
    result: dict[int, tuple[Condition, ...]] = {}

    def walk(node: int, limits: dict[str, tuple[float, float]]) -> None:
        if tree.children_left[node] < 0:
            result[node] = tuple(
                Condition(
                    feature=name,
                    above=low if np.isfinite(low) else None,
                    below=high if np.isfinite(high) else None,
                )
                for name, (low, high) in limits.items()
            )
            return
        name, cut = names[tree.feature[node]], float(tree.threshold[node])
        low, high = limits.get(name, (-np.inf, np.inf))
        walk(int(tree.children_left[node]), limits | {name: (low, min(high, cut))})
        walk(int(tree.children_right[node]), limits | {name: (max(low, cut), high)})

    walk(0, {})
    return result


def admissible(rules: Rules, features: pd.DataFrame) -> np.ndarray:
    """(n,) bool: which rows the rules admit."""
    return np.array([not rules.broken(row) for row in features.to_dict("records")], bool)


def write_rules(path: Path, rules: Rules) -> None:
    """Write `rules.yaml`."""
    rounded = [[_rounded(condition) for condition in alternative] for alternative in rules.any_of]
    about = {
        "schema": SCHEMA,
        "method": rules.method,
        "reason": rules.reason,
        "any_of": [{"all_of": c} for c in rounded],
    }
    path.write_text(yaml.safe_dump(about, sort_keys=False, width=110))


def _rounded(condition: Condition) -> dict[str, Any]:
    """Six digits, rounded outwards, so that what was admitted stays admitted."""
    entry = asdict(condition)
    for key, sign in (("above", -1), ("below", 1)):
        if entry[key] is not None:
            entry[key] = float(f"{entry[key] + sign * 1e-5 * (1 + abs(entry[key])):.6g}")
    return {key: value for key, value in entry.items() if value is not None}


def _condition(entry: dict[str, Any]) -> Condition:
    """Of an entry of `all_of`; raises TypeError or ValueError where a name is no text or a limit no finite number."""
    condition = Condition(**entry)
    if not isinstance(condition.feature, str):
        raise ValueError(f"feature is {condition.feature!r}, expected its name")
    for key, limit in (("above", condition.above), ("below", condition.below)):
        if limit is not None and (
            isinstance(limit, bool) or not isinstance(limit, int | float) or not np.isfinite(limit)
        ):
            raise ValueError(f"{key} of {condition.feature} is {limit!r}, expected a number")
    return condition


def read_rules(path: Path) -> Rules:
    """Read `rules.yaml`, as `write_rules` wrote it.

    Raises:
        BadInput: not readable, another schema, an unknown key, or a value of another type.
    """
    try:
        about = yaml.safe_load(path.read_text())
        if not isinstance(about, dict) or about.get("schema") != SCHEMA:
            raise ValueError(f"schema is not {SCHEMA!r}")
        alternatives = tuple(tuple(map(_condition, item["all_of"])) for item in about["any_of"])
        return Rules(method=str(about["method"]), reason=str(about["reason"]), any_of=alternatives)
    except (OSError, yaml.YAMLError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: not readable rules ({error}); make state_rules again") from error
