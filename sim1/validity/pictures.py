"""Pictures of the validity room."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim1.picture_file import save_figure
from sim1.validity.rules import Rules

GOOD, BAD = "tab:green", "tab:red"
SHOWN = 14  # conditions in a picture; the rest is in rules.yaml


def draw_rules(path: Path, rules: Rules, table: pd.DataFrame) -> None:
    """Every condition's admissible range with the examples on it, those that reject most failures first."""
    conditions = [condition for alternative in rules.any_of for condition in alternative]
    bad = table[~table.success]
    order = sorted(conditions, key=lambda item: -sum(not item.holds(value) for value in bad[item.feature]))[:SHOWN]
    figure = Figure(figsize=(8.6, 1.3 + 0.34 * max(len(order), 1)), layout="constrained")
    axes = figure.subplots()
    for row, condition in enumerate(order):
        values = table[condition.feature].to_numpy(float)
        ends = [limit for limit in (condition.above, condition.below) if limit is not None]
        low, high = min([*values, *ends]), max([*values, *ends])
        span = max(high - low, 1e-9)
        left = 0.0 if condition.above is None else (condition.above - low) / span
        right = 1.0 if condition.below is None else (condition.below - low) / span
        axes.barh(row, right - left, left=left, height=0.6, color="#d8ead3")
        for outcome, color, marker, lift in ((True, GOOD, "o", -0.12), (False, BAD, "x", 0.12)):
            here = (values[table.success.to_numpy(bool) == outcome] - low) / span
            axes.plot(here, np.full(len(here), row + lift), marker, color=color, markersize=5)
        axes.text(1.02, row, _limits(condition.above, condition.below), va="center", fontsize=7)
    axes.set_yticks(range(len(order)), [condition.feature for condition in order], fontsize=8)
    axes.set(
        xlim=(-0.03, 1.32),
        xticks=[],
        xlabel="value, each row on its own scale; limits in the figure's unit at the right",
    )
    axes.invert_yaxis()
    counts = f"{int(table.success.sum())} successes (green), {len(bad)} failures (red)"
    figure.suptitle(
        f"State rules by {rules.method}: {len(order)} of {len(conditions)} conditions, {counts}", fontsize=10
    )
    save_figure(figure, path, dpi=90)


def _limits(above: float | None, below: float | None) -> str:
    if above is None:
        return f"at most {below:.3g}"
    if below is None:
        return f"at least {above:.3g}"
    return f"{above:.3g} to {below:.3g}"


def draw_scores(path: Path, rows: list[dict[str, Any]], threshold: float, reason: str) -> None:
    """Score of every clip by outcome and part, and the ROC of the test clips where there are any of both."""
    figure = Figure(figsize=(8.6, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    names = {"train": "trained on", "calibration": "calibration", "test": "test"}
    lines = [(success, part) for success in (True, False) for part in names]
    for place, (success, part) in enumerate(lines):
        here = [row["score"] for row in rows if row["success"] is success and row["part"] == part]
        left.plot(here, np.full(len(here), place), "o" if success else "x", color=GOOD if success else BAD)
    left.axvline(threshold, color="0.3", linestyle="--", label=f"threshold {threshold:.2f}")
    told = [f"{'success' if success else 'failure'}, {names[part]}" for success, part in lines]
    left.set_yticks(range(len(lines)), told)
    left.set(
        xlim=(-0.03, 1.03), ylim=(-0.6, 5.6), xlabel="score: probability of being valid", title="Clips of the head view"
    )
    left.legend(fontsize=8, loc="upper center")
    _draw_roc(right, [row for row in rows if row["part"] == "test"])
    head = f"Abstains: {reason}" if reason else "Video discriminator"
    figure.suptitle(head, fontsize=9, wrap=True)
    save_figure(figure, path, dpi=90)


def _draw_roc(axes: Any, seen: list[dict[str, Any]]) -> None:
    success = np.array([row["success"] for row in seen], bool)
    axes.plot([0, 1], [0, 1], color="0.8")
    if success.any() and not success.all():
        from sklearn.metrics import roc_curve

        false, true, _ = roc_curve(success, [row["score"] for row in seen])
        axes.plot(false, true, "o-", color="tab:blue", markersize=3)
    else:
        axes.text(0.5, 0.5, "no test clips\nof both outcomes", ha="center", va="center", fontsize=9)
    axes.set(
        xlabel="share of failures accepted",
        ylabel="share of successes accepted",
        title=f"ROC, {len(seen)} test clips",
    )


def draw_decisions(path: Path, rows: list[dict[str, Any]], video_silent: bool) -> None:
    """A table of dots: what judge, rules and video say of every candidate, and the decision."""
    columns = [("judge", "success"), ("rules", "rules_pass"), ("video", "video_pass"), ("accepted", "accepted")]
    figure = Figure(figsize=(11, 1.2 + 0.3 * len(rows)), layout="constrained")
    axes = figure.subplots()
    for line, row in enumerate(rows):
        for column, (_, key) in enumerate(columns):
            silent = key == "video_pass" and video_silent
            color = "0.75" if silent else GOOD if row[key] else BAD
            marker = "_" if silent else "o" if row[key] else "X"  # legible without colours too
            axes.plot(column, line, marker, color=color, markersize=9)
        axes.text(len(columns) - 0.6, line, _shortened(row["reasons"], 95), va="center", fontsize=7)
    axes.set_xticks(range(len(columns)), [name for name, _ in columns])
    axes.set_yticks(range(len(rows)), [row["episode"] + (" (perturbed)" if row["perturbed"] else "") for row in rows])
    axes.set(xlim=(-0.5, len(columns) + 6.5), ylim=(len(rows) - 0.5, -0.5))
    axes.xaxis.tick_top()
    for side in ("top", "right", "bottom", "left"):
        axes.spines[side].set_visible(False)
    grey = ", dash: abstains or not asked" if video_silent else ""
    counts = [_accepted([row for row in rows if row["perturbed"] is disturbed]) for disturbed in (False, True)]
    told = f"{counts[0]} candidates accepted, {counts[1]} perturbed on purpose (dot: passes, cross: fails{grey})"
    figure.suptitle(told, fontsize=10)
    save_figure(figure, path, dpi=90)


def _accepted(rows: list[dict[str, Any]]) -> str:
    return f"{sum(row['accepted'] for row in rows)} of {len(rows)}"


def _shortened(text: str, length: int) -> str:
    return text if len(text) <= length else text[: length - 2] + " …"
