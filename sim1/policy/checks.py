"""What must hold in the artifacts of this room."""

import json
import math
import re
from collections.abc import Mapping, Sequence
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np

from sim1.policy.cost import pace_of
from sim1.policy.counting import read_figures, read_table
from sim1.policy.experiment import ABOUT_SCHEMA
from sim1.policy.lessons import GENERATED, REAL, ModelKey
from sim1.policy.model import load_policy
from sim1.report import format_value
from sim1.stage import BadInput, Finding

COUNTS = ("success_count", "trial_count")


def check_experiment(artifact: Path) -> list[Finding]:
    """Findings of stage `policy`."""
    about = read_figures(artifact / "policy.json", ABOUT_SCHEMA, "policy")
    open_loop, trials = read_table(artifact / "open_loop.parquet"), read_table(artifact / "evaluation.parquet")
    keys = [
        ModelKey(kind, n, seed)
        for kind, one in about["lessons"].items()
        for n in one["sizes"]
        for seed in about["seeds"]
    ]
    expected = {key.file for key in keys}
    found = {path.name for path in (artifact / "policies").iterdir()}
    findings = [
        Finding(
            name="every_model_saved", passed=expected == found, detail=f"{len(found)} files of {len(expected)} models"
        )
    ]
    bad = []
    for name in sorted(found & expected):
        try:
            model = load_policy(artifact / "policies" / name)
        except BadInput as error:
            bad.append(str(error))
            continue
        if not model.is_finite():
            bad.append(name)
    findings.append(Finding(name="weights_finite", passed=not bad, detail=", ".join(bad) or f"{len(found)} models"))
    plan = about["trials"]
    wanted = {
        (*key, garment, shift, trial)
        for garment, drivers in plan["models"].items()
        for key in drivers
        for shift in plan["shifts"]
        for trial in range(plan["each"])
    }
    columns = [*ModelKey._fields, "garment", "shift", "trial"]
    rows = list(trials[columns].itertuples(index=False, name=None))
    findings.append(
        Finding(
            name="every_trial_accounted_for",
            passed=sorted(rows) == sorted(wanted),
            detail=f"{len(rows)} rows of {len(wanted)} planned trials",
        )
    )
    strangers = [
        f"{garment} by {ModelKey(*key).file}"
        for garment, drivers in plan["models"].items()
        for key in drivers
        if not _was_shown(garment, about["lessons"][key[0]]["training_sets"][str(key[1])][str(key[2])])
    ]
    findings.append(
        Finding(
            name="nobody_drives_what_it_was_not_shown",
            passed=not strangers,
            detail=f"garments that no training trajectory shows: {', '.join(strangers) or 'none'}",
        )
    )
    silent = int((~trials["success"].astype(bool) & trials["failure"].isna()).sum())
    findings.append(
        Finding(name="every_failure_has_a_class", passed=silent == 0, detail=f"{silent} failures without a class")
    )
    held = {kind: one["held_out_count"] for kind, one in about["lessons"].items()}
    # All policies are tested on the real ones as well.
    tested = sum(held[kind] for key in keys for kind in held if kind in (key.trained_on, REAL))
    findings.append(
        Finding(
            name="every_held_out_error_measured",
            passed=len(open_loop) == tested,
            detail=f"{len(open_loop)} of {tested} rows",
        )
    )
    if held[GENERATED]:
        size = max(about["lessons"][GENERATED]["sizes"])
        largest = open_loop[(open_loop["size"] == size) & (open_loop["tested_on"] == GENERATED)]
        error, hold = (float(np.degrees(largest[key].mean())) for key in ("joint_error_rad", "hold_joint_error_rad"))
        findings.append(
            Finding(
                name="better_than_standing_still",
                passed=error < hold,
                detail=f"held-out joint error {error:.2f} degrees, standing still {hold:.2f} degrees, size {size}",
                blocking=False,  # with a handful of trajectories this is a result, not a defect
            )
        )
    return findings


def _was_shown(garment: str, training_set: list[str]) -> bool:
    """`training_set`: trajectories as `GARMENT/NAME`."""
    return any(name.startswith(f"{garment}/") for name in training_set)


def check_curve(artifact: Path) -> list[Finding]:
    """Findings of stage `scaling_report`."""
    points = json.loads((artifact / "curve.json").read_text())["points"]
    tried = [one for point in points for one in point["trials"]]
    errors = [error for point in points for error in point["errors"]]
    shares = [(one["success_count"] / one["trial_count"], one["interval"]) for one in tried]
    means = [(error["joint_error_rad"], error["interval_rad"]) for error in errors if error["interval_rad"]]
    apart = [
        f"{point['size']} {point['trained_on']}"
        for point in points
        if point["all_trials"]
        and any(sum(one[key] for one in point["trials"]) != point["all_trials"][key] for key in COUNTS)
    ]
    return [
        *page_findings(artifact, [f"{one['success_count']} of {one['trial_count']}" for one in tried]),
        intervals_held([*shares, *means]),
        Finding(name="shifts_add_up", passed=not apart, detail=f"counts of all shifts that are not: {apart or 'none'}"),
    ]


def intervals_held(values: Sequence[tuple[float, Sequence[float]]]) -> Finding:
    """Of values with their intervals."""
    outside = [value for value, (low, high) in values if not low - 1e-12 <= value <= high + 1e-12]
    return Finding(
        name="intervals_hold_their_values",
        passed=not outside,
        detail=f"{len(values)} intervals, values outside: {outside or 'none'}",
    )


def check_table(artifact: Path) -> list[Finding]:
    """Findings of stage `ablation_report`."""
    rows = json.loads((artifact / "table.json").read_text())["rows"]
    counts = [f"{row['accepted_count']} of {row['candidate_count']}" for row in rows]
    tried = [row for row in rows if row["all_trials"]]
    compared = [row["over_base"] for row in rows if row["over_base"]]
    values = [
        *((row["pass_rate"], row["pass_rate_ci95"]) for row in rows if row["candidate_count"]),
        *((row["success_rate"], row["all_trials"]["interval"]) for row in tried),
        *((one["value"], one["interval"]) for one in compared),
    ]
    odd = [row["variant"] for row in rows if not _fit_together(row)]
    pairs = ["1 pair" if one["pair_count"] == 1 else f"{one['pair_count']} pairs" for one in compared]
    return [
        *page_findings(artifact, [*counts, *(row["variant"] for row in rows), *pairs]),
        intervals_held(values),
        Finding(name="counts_fit_together", passed=not odd, detail=f"variants whose counts do not: {odd or 'none'}"),
    ]


def _fit_together(row: Mapping[str, Any]) -> bool:
    """Parts are no more than the whole, and shifts add up to it."""
    pairs = row["over_base"]["pair_count"] if row["over_base"] else 0
    return (
        row["accepted_and_successful_count"] <= row["accepted_count"] <= row["candidate_count"]
        and pairs <= row["trial_count"]
        and all(sum(one[key] for one in row["shifts"]) == row[key] for key in COUNTS)
    )


def check_costs(artifact: Path) -> list[Finding]:
    """Findings of stage `cost_report`."""
    costs = json.loads((artifact / "costs.json").read_text())
    methods = costs["methods"]
    figures = [value for item in methods for value in item.values() if isinstance(value, int | float)]
    bad = [value for value in figures if not 0 <= value < math.inf]
    units = [format_value(round(item["usd_per_trajectory"], 4)) for item in methods]
    return [
        *page_findings(artifact, [*(item["method"] for item in methods), *units]),
        Finding(name="costs_are_numbers", passed=not bad, detail=f"neither zero nor positive: {bad or 'none'}"),
        _measured(costs),
    ]


def _measured(costs: Mapping[str, Any]) -> Finding:
    """Of the machine at hand: it stands there where its seconds are known, and a day at its pace has as many as a day has."""
    pace = pace_of(costs["seconds"], *(costs[f"{name}_count"] for name in ("attempted", "accepted", "shown")))
    known = pace is not None
    here = [item for item in costs["methods"] if item["measured"]]
    days = [item["trajectories_per_day"] * pace.trajectory_s for item in here] if known else []
    return Finding(
        name="pace_follows_from_seconds",
        passed=len(here) == int(known) and bool(np.allclose(days, 86400.0)),
        detail=f"{len(here)} measured, seconds {'known' if known else 'not known'}, a day has {days or 'no'} seconds",
    )


class _Page(HTMLParser):
    """Text of a page, and the addresses it points to."""

    def __init__(self) -> None:
        super().__init__()
        self.text: list[str] = []
        self.outside: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.outside += [
            value or "" for name, value in attrs if name in {"src", "href"} and not (value or "").startswith("data:")
        ]

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def page_findings(artifact: Path, must_say: list[str]) -> list[Finding]:
    """`report.html` holds these words, and needs no other file."""
    page = _Page()
    page.feed((artifact / "report.html").read_text())
    text = " ".join(page.text).replace("\N{NO-BREAK SPACE}", " ")
    # "3 of 50" does not stand where "43 of 50" does.
    missing = [words for words in must_say if not re.search(rf"(?<!\d){re.escape(words)}(?!\d)", text)]
    return [
        Finding(name="page_states_its_counts", passed=not missing, detail=f"not on the page: {missing or 'nothing'}"),
        Finding(
            name="page_stands_alone", passed=not page.outside, detail=f"links to the outside: {page.outside or 'none'}"
        ),
    ]
