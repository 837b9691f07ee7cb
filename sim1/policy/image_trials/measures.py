"""What the trials of an image policy say: success in every shift, and what a shift changes, pair by pair."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pydantic

from sim1.policy.counting import read_figures
from sim1.policy.image_trials.looks import SHIFTS
from sim1.stage import BadInput, random_stream
from sim1.statistics import Interval, bootstrap_mean_interval, wilson_interval

SCHEMA = "sim1.image_trials/1"  # of image_trials.json
IN_DOMAIN = "in-domain"


@dataclass(frozen=True, kw_only=True)
class Change:
    """Success in a shift minus that in-domain, over trials of the same garment and number."""

    pair_count: int
    value: float  # mean of the differences, each -1, 0 or 1
    interval: Interval | None  # 95 %, bootstrap over pairs; None: there is one


@dataclass(frozen=True, kw_only=True)
class Tried:
    """Trials in one shift, of all garments or of one."""

    shift: str
    garment: str | None  # None: all together
    trial_count: int
    success_count: int
    interval: Interval  # Wilson, 95 %
    failures: Mapping[str, int]  # class -> count, frequent ones first
    change: Change | None  # None: in-domain itself, or that was not run


def measure(trials: pd.DataFrame, seed: int) -> list[Tried]:
    """Every shift of all garments together, then of each where there are several; `seed`: of the bootstrap."""
    garments = list(dict.fromkeys(trials["garment"]))
    parts = [(None, trials), *((name, trials[trials["garment"] == name]) for name in garments if len(garments) > 1)]
    return [
        _tried(part, shift, garment, seed)
        for garment, part in parts
        for shift in SHIFTS
        if (part["shift"] == shift).any()
    ]


def read_result(artifact: Path) -> tuple[dict[str, Any], list[Tried]]:
    """Contents of `image_trials.json`, and what was measured.

    Raises:
        BadInput: missing, damaged, or of another version.
    """
    path = artifact / "image_trials.json"
    about = read_figures(path, SCHEMA, "image_trials")
    try:
        return about, pydantic.TypeAdapter(list[Tried]).validate_python(about["tried"])
    except (KeyError, pydantic.ValidationError) as error:
        raise BadInput(f"{path}: not readable ({error}); make image_trials again") from error


def of_all(tried: Sequence[Tried]) -> list[Tried]:
    """Those of all garments together."""
    return [one for one in tried if one.garment is None]


def _tried(trials: pd.DataFrame, shift: str, garment: str | None, seed: int) -> Tried:
    own = trials[trials["shift"] == shift]
    successes = int(own["success"].sum())
    return Tried(
        shift=shift,
        garment=garment,
        trial_count=len(own),
        success_count=successes,
        interval=wilson_interval(successes, len(own)),
        failures=dict(sorted(Counter(own["failure"].dropna()).items(), key=lambda item: (-item[1], item[0]))),
        change=None if shift == IN_DOMAIN else _change(trials, shift, garment, seed),
    )


def _change(trials: pd.DataFrame, shift: str, garment: str | None, seed: int) -> Change | None:
    by = trials.set_index(["garment", "trial"])["success"].astype(float)
    own, plain = (by[(trials["shift"] == name).to_numpy()] for name in (shift, IN_DOMAIN))
    differences = (own - plain).dropna().to_numpy()
    if not len(differences):
        return None
    stream = random_stream(seed, "image trials", garment or "", shift)
    interval = bootstrap_mean_interval(differences, stream) if len(differences) > 1 else None
    return Change(pair_count=len(differences), value=float(np.mean(differences)), interval=interval)
