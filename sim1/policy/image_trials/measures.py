"""What the trials of image policies say: success in every shift, and what a shift changes, pair by pair."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import pydantic

from sim1.clustered_share import Difference
from sim1.policy import paper
from sim1.policy.counting import read_figures
from sim1.policy.image_trials.looks import SHIFTS
from sim1.policy.tried import Tried, compare, count
from sim1.stage import BadInput

SCHEMA = "sim1.image_trials/3"  # of image_trials.json
IN_DOMAIN = "in-domain"


@dataclass(frozen=True, kw_only=True)
class ShiftTried(Tried):
    """Trials in one shift or, named `paper.AVERAGE`, in all; of all garments or of one."""

    garment: str | None  # None: all together
    failures: Mapping[str, int]  # class -> count, frequent ones first
    # Success minus that in-domain, in pairs; None: in-domain itself, all, or that was not run.
    change: Difference | None


def measure(trials: pd.DataFrame) -> list[ShiftTried]:
    """Every shift and all of them, of all garments together; then every shift of each where there are several."""
    garments = list(dict.fromkeys(trials["garment"]))
    parts = [(None, trials), *((name, trials[trials["garment"] == name]) for name in garments if len(garments) > 1)]
    shifts = [
        _tried(part, part[part["shift"] == shift], shift, garment)
        for garment, part in parts
        for shift in SHIFTS
        if (part["shift"] == shift).any()
    ]
    return [*shifts, _tried(trials, trials, paper.AVERAGE, None)] if shifts else []


def read_result(artifact: Path) -> tuple[dict[str, Any], list[ShiftTried]]:
    """Contents of `image_trials.json`, and what was measured.

    Raises:
        BadInput: missing, damaged, or of another version.
    """
    path = artifact / "image_trials.json"
    about = read_figures(path, SCHEMA, "image_trials")
    try:
        return about, pydantic.TypeAdapter(list[ShiftTried]).validate_python(about["tried"])
    except (KeyError, pydantic.ValidationError) as error:
        raise BadInput(f"{path}: not readable ({error}); make image_trials again") from error


def by_shift(tried: Sequence[ShiftTried]) -> list[ShiftTried]:
    """Those of one shift and all garments together."""
    return [one for one in tried if one.garment is None and one.shift != paper.AVERAGE]


def of_all(tried: Sequence[ShiftTried]) -> ShiftTried | None:
    """All trials together."""
    return next((one for one in tried if one.shift == paper.AVERAGE), None)


def _tried(trials: pd.DataFrame, own: pd.DataFrame, shift: str, garment: str | None) -> ShiftTried:
    compared = shift not in (IN_DOMAIN, paper.AVERAGE)
    return ShiftTried(
        **vars(count(own, shift)),
        garment=garment,
        failures=dict(sorted(Counter(own["failure"].dropna()).items(), key=lambda item: (-item[1], item[0]))),
        change=compare(own, trials[trials["shift"] == IN_DOMAIN]) if compared else None,
    )
