"""All figures of one set of paths against the demonstrations, or the reason why one of them was not measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sim1.motion.likeness.classifier import area_under_roc, told_apart
from sim1.motion.likeness.copies import COPY_SHARE, nearest_distances, nearest_of_the_rest
from sim1.motion.likeness.distances import frechet_distance, mmd, standardised
from sim1.motion.likeness.families import FAMILY_MINIMUM, families
from sim1.motion.likeness.features import FEATURES, Movement, features, shape
from sim1.motion.likeness.joins import ORDERS, common_steps, join_ratios
from sim1.motion.likeness.smoothness import (
    log_dimensionless_jerk,
    path_ratio,
    spectral_arc_length,
    speed,
    speed_peaks,
)

SET_MINIMUM = 16  # transitions of either set: fewer say nothing of a distribution
COPY_MINIMUM = 4  # transitions of the demonstrations, two of each kind: else they have no distances of their own


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A measured number, or why there is none."""

    value: float | None
    low: float | None = None  # of an interval or a range
    high: float | None = None
    p_value: float | None = None
    missing: str = ""

    def record(self) -> dict[str, Any]:
        """As JSON: what there is of it."""
        parts = {"value": self.value, "low": self.low, "high": self.high, "p_value": self.p_value}
        return {key: value for key, value in parts.items() if value is not None} | (
            {"not_measured": self.missing} if self.missing else {}
        )


@dataclass(frozen=True, kw_only=True)
class Paths:
    """Whole paths from home to home, and the transitions in them."""

    tools: list[np.ndarray]  # each (T, 2, 3) [m]
    joints: list[np.ndarray]  # each (T, 2, 6) [rad]
    joins: list[list[int]]  # of each path: first frame of every part but the first
    movements: list[Movement]


def compare(demos: Paths, others: Paths, permutation_count: int, rng: np.random.Generator) -> dict[str, Figure]:
    """Figures of `others`."""
    one, two = _features(demos.movements), _features(others.movements)
    kin = families([item.sources for item in (*demos.movements, *others.movements)])
    own, theirs = kin[: len(one)], kin[len(one) :]

    def sets() -> dict[str, Figure]:
        a, b = standardised(one, two)
        discrepancy = mmd(a, b, own, theirs, permutation_count, rng)
        auc = told_apart(one, two, own, theirs, rng)
        return {
            "frechet": Figure(value=frechet_distance(a, b)),
            "mmd": Figure(value=discrepancy.value, p_value=discrepancy.p_value),
            "auc": Figure(value=auc.value, low=auc.low, high=auc.high),
        }

    matched = len(np.intersect1d(own, theirs))
    return of_paths(demos, others) | _of_sets(min(len(one), len(two)), matched, "", sets) | _copies(demos, others)


def chance(demos: Paths, split_count: int, rng: np.random.Generator) -> dict[str, Figure]:
    """The same figures of the demonstrations themselves; sets are random halves of them, and ranges are over splits."""
    kin = families([item.sources for item in demos.movements])
    names, sizes = np.unique(kin, return_counts=True)
    rows, half = _features(demos.movements), len(names) // 2

    def sets() -> dict[str, Figure]:
        drawn: dict[str, list[float]] = {"frechet": [], "mmd": [], "auc": []}
        for _ in range(split_count):
            first = np.isin(kin, rng.permutation(names)[:half])
            one, two = rows[first], rows[~first]
            a, b = standardised(one, two)
            drawn["frechet"].append(frechet_distance(a, b))
            drawn["mmd"].append(mmd(a, b, kin[first], kin[~first], 0, rng).value)
            drawn["auc"].append(told_apart(one, two, kin[first], kin[~first], rng, 0).value)
        return {key: _range(values) for key, values in drawn.items()}

    fewest = int(np.sort(sizes)[:half].sum())
    result = of_paths(demos, demos) | _of_sets(fewest, half, " in half of the demonstrations", sets)

    def nearest() -> dict[str, Figure]:
        own = np.concatenate([nearest_of_the_rest(part) for part in _shapes(demos.movements).values()])
        return {"nearest": Figure(value=float(np.median(own)), low=float(own.min()), high=float(own.max()))}

    return result | _where(("nearest",), _least(demos.movements), COPY_MINIMUM // 2, nearest)


def telling(demos: Paths, others: Paths, count: int) -> list[dict[str, Any]]:
    """The features that on their own tell the sets apart best, the most telling first; none where there are too few."""
    if min(len(demos.movements), len(others.movements)) < SET_MINIMUM:
        return []
    one, two = _features(demos.movements), _features(others.movements)
    rows = []
    for order in np.unique(one[:, 0]):
        a, b = one[one[:, 0] == order], two[two[:, 0] == order]
        labels = np.repeat([0, 1], [len(a), len(b)])
        for index, feature in enumerate(FEATURES):
            auc = area_under_roc(labels, np.concatenate([a[:, index], b[:, index]]))
            row = {"transition": int(order) + 1, "feature": feature, "auc": max(auc, 1 - auc)}
            for name, values in (("demonstrated", a[:, index]), ("generated", b[:, index])):
                row |= {f"{name}_mean": float(values.mean()), f"{name}_std": float(values.std())}
            rows.append(row)
    return sorted(rows, key=lambda row: -row["auc"])[:count]


def of_paths(demos: Paths, others: Paths) -> dict[str, Figure]:
    """Figures that every single path has, whatever it is compared with: joins, smoothness, directness."""
    result = {}
    for name, scale, measured in (("tool", demos.tools, others.tools), ("joint", demos.joints, others.joints)):
        ratios = join_ratios(measured, others.joins, common_steps(scale))
        for order, ratio in zip(ORDERS, ratios, strict=True):
            result[f"join_{name}_{order}"] = Figure(value=float(ratio))
        if name == "tool":
            result["join"] = Figure(value=float(ratios.max()))
    jerk = _relative(demos.movements, others.movements, log_dimensionless_jerk)
    direct = _relative(demos.movements, others.movements, lambda way: np.log(path_ratio(way)))
    ways = [item.path.position_m[:, arm] for item in others.movements for arm in item.arms]
    return result | {
        "log_jerk": Figure(value=float(np.median([log_dimensionless_jerk(way) for way in ways]))),
        "jerk_share": Figure(value=float(np.exp(-jerk))),
        "sparc": Figure(value=float(np.median([spectral_arc_length(speed(way)) for way in ways]))),
        "path_ratio": Figure(value=float(np.median([path_ratio(way) for way in ways]))),
        "path_share": Figure(value=float(np.exp(direct))),
        "peaks": Figure(value=float(np.mean([speed_peaks(way) for way in ways]))),
    }


def _relative(demos: Sequence[Movement], others: Sequence[Movement], figure: Callable[[np.ndarray], float]) -> float:
    """Median over movements of a figure less the demonstrations' median at the same place of the task."""

    def by_order(movements: Sequence[Movement]) -> dict[int, list[float]]:
        rows: dict[int, list[float]] = {}
        for item in movements:
            rows.setdefault(item.order, []).extend(figure(item.path.position_m[:, arm]) for arm in item.arms)
        return rows

    middle = {order: np.median(values) for order, values in by_order(demos).items()}
    return float(
        np.median(
            [value - middle[order] for order, values in by_order(others).items() if order in middle for value in values]
        )
    )


def _copies(demos: Paths, others: Paths) -> dict[str, Figure]:
    def nearest() -> dict[str, Figure]:
        theirs, shares = _shapes(demos.movements), []
        apart = []
        for order, part in _shapes(others.movements).items():
            if order not in theirs:  # demonstrations had nothing to copy there
                continue
            smallest = nearest_of_the_rest(theirs[order]).min()
            found = nearest_distances(part, theirs[order])
            apart.append(found)
            shares.append(found < COPY_SHARE * smallest)
        distance = np.concatenate(apart)
        return {
            "nearest": Figure(value=float(np.median(distance)), low=float(distance.min()), high=float(distance.max())),
            "copies": Figure(value=float(np.concatenate(shares).sum())),
        }

    return _where(("nearest", "copies"), _least(demos.movements), COPY_MINIMUM // 2, nearest)


def _shapes(movements: Sequence[Movement]) -> dict[int, np.ndarray]:
    rows: dict[int, list[np.ndarray]] = {}
    for item in movements:
        rows.setdefault(item.order, []).append(shape(item))
    return {order: np.stack(parts) for order, parts in sorted(rows.items())}


def _features(movements: Sequence[Movement]) -> np.ndarray:
    return np.stack([features(item) for item in movements])


def _least(movements: Sequence[Movement]) -> int:
    """Demonstrations of the rarest kind of transition."""
    return min(len(part) for part in _shapes(movements).values())


def _where(names: Sequence[str], count: int, needed: int, measure: Callable[[], dict[str, Figure]]) -> dict[str, Figure]:  # fmt: skip
    if count < needed:
        return _not_measured(names, f"{count} transitions, {needed} needed")
    return measure()


def _of_sets(count: int, family_count: int, where: str, measure: Callable[[], dict[str, Figure]]) -> dict[str, Figure]:
    """Figures of sets against sets, or why they say nothing: too few transitions, or too few that are independent."""
    if count < SET_MINIMUM:
        return _not_measured(("frechet", "mmd", "auc"), f"{count} transitions{where}, {SET_MINIMUM} needed")
    if family_count < FAMILY_MINIMUM:
        what = "families of demonstrations and what is made of them"
        return _not_measured(("frechet", "mmd", "auc"), f"{family_count} {what}{where}, {FAMILY_MINIMUM} needed")
    return measure()


def _not_measured(names: Sequence[str], reason: str) -> dict[str, Figure]:
    return {name: Figure(value=None, missing=reason) for name in names}


def _range(values: list[float]) -> Figure:
    low, middle, high = np.quantile(values, [0.05, 0.5, 0.95])
    return Figure(value=float(middle), low=float(low), high=float(high))
