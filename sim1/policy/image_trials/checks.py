"""What must hold in the artifact of stage `image_trials`."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sim1.policy.checks import intervals_held, page_findings
from sim1.policy.counting import rate, read_table
from sim1.policy.image_trials.measures import ShiftTried, by_shift, read_result
from sim1.policy.trials import BROKEN
from sim1.stage import Finding


def check_experiment(artifact: Path) -> list[Finding]:
    """Findings of stage `image_trials`."""
    about, tried = read_result(artifact)
    trials = read_table(artifact / "trials.parquet")
    counts = [
        rate(one.success_count, one.trial_count, one.interval).replace("\N{NO-BREAK SPACE}", " ") for one in tried
    ]
    return [
        _complete(trials, about),
        _finite(trials),
        _paired(trials),
        _seen(trials, about),
        _strips(artifact, trials),
        _counted(trials, tried),
        intervals_held([(one.success_count / one.trial_count, one.interval) for one in tried]),
        intervals_held([(one.change.value, one.change.interval) for one in tried if one.change]),
        *page_findings(artifact, [*counts, "no robot", "stand-in"]),
    ]


def _complete(trials: pd.DataFrame, about: dict[str, Any]) -> Finding:
    wanted = {
        (garment, seed, shift, number)
        for garment in about["garments"]
        for seed in about["network_seeds"]
        for shift in about["shifts"]
        for number in range(about["each"])
    }
    rows = list(trials[["garment", "seed", "shift", "trial"]].itertuples(index=False, name=None))
    silent = int((~trials["success"].astype(bool) & trials["failure"].isna()).sum())
    return Finding(
        name="every_trial_accounted_for",
        passed=sorted(rows) == sorted(wanted) and not silent,
        detail=f"{len(rows)} rows of {len(wanted)} planned trials, {silent} failures without a class",
    )


def _finite(trials: pd.DataFrame) -> Finding:
    figures = [value for text in trials["figures"] for value in json.loads(text).values()]
    numbers = [*trials.select_dtypes("number").to_numpy(float).ravel(), *figures]
    bad = int((~np.isfinite(numbers)).sum()) if numbers else 0
    return Finding(name="figures_finite", passed=not bad, detail=f"{bad} of {len(numbers)} numbers are not finite")


def _counted(trials: pd.DataFrame, tried: Sequence[ShiftTried]) -> Finding:
    """Counts on record are those of the table, pairs no more than trials, and failures all that did not succeed."""
    rows = {shift: (int(own.sum()), len(own)) for shift, own in trials.groupby("shift")["success"]}
    told = {one.shift: (one.success_count, one.trial_count) for one in by_shift(tried)}
    odd = [
        f"{one.shift} {one.garment or ''}".strip()
        for one in tried
        if one.success_count + sum(one.failures.values()) != one.trial_count
        or (one.change and one.change.pair_count > one.trial_count)
    ]
    return Finding(
        name="figures_follow_from_trials",
        passed=rows == told and not odd,
        detail=f"successes and trials {told}, in the table {rows}; parts that do not add up: {odd or 'none'}",
    )


def _paired(trials: pd.DataFrame) -> Finding:
    """Trials of one network and number begin in one look of training, and where the shift is no spatial one in one place."""
    by = ["garment", "seed", "trial"]
    laid = trials[trials["shift"] != "spatial"]
    odd = [
        *trials.groupby(by)["trained_look"].nunique(),
        *(count for column in ("shift_x_m", "shift_y_m", "turn_rad") for count in laid.groupby(by)[column].nunique()),
    ]
    wrong = sum(count != 1 for count in odd)
    return Finding(name="shifts_compare_in_pairs", passed=not wrong, detail=f"{wrong} of {len(odd)} differ")


def _seen(trials: pd.DataFrame, about: dict[str, Any]) -> Finding:
    """A picture whenever it planned, to the end unless the simulation broke."""
    driving, short = about["driving"], []
    for row in trials.itertuples():
        frames = int(about["time_limits"][row.garment]["duration_s"] * driving["rate_hz"])
        planned = -(-frames // driving["replan_frames"])
        least = 1 if row.failure == BROKEN else planned
        if not least <= row.picture_count <= planned:
            short.append(f"{row.garment} {row.seed} {row.shift} {row.trial}: {row.picture_count} of {planned}")
    return Finding(name="every_plan_saw_a_picture", passed=not short, detail=", ".join(short[:3]) or "all")


def _strips(artifact: Path, trials: pd.DataFrame) -> Finding:
    missing = [shift for shift in dict.fromkeys(trials["shift"]) if not (artifact / f"trials_{shift}.png").exists()]
    return Finding(name="film_strips_present", passed=not missing, detail=f"missing: {', '.join(missing) or 'none'}")
