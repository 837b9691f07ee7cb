"""What the errors on held-out trajectories say, with intervals over trajectories and networks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pydantic

from sim1.data_file import explained
from sim1.policy.counting import read_figures
from sim1.policy.error_table import error_table, interval_of
from sim1.policy.image.shifts import IN_DOMAIN, TITLES
from sim1.stage import BadInput, random_stream
from sim1.statistics import Interval

SCHEMA = "sim1.image_policy_result/3"  # of image_policy.json
DATASET, BLANK = "dataset", "no_picture"
ERRORS = ("joint_error_rad", "openness_error")  # columns
ALL_TITLES = {DATASET: "as in the dataset", **TITLES, BLANK: "no picture, its mean colour"}


@dataclass(frozen=True, kw_only=True)
class Mean:
    """Mean over trajectories and networks, with a bootstrap over either; no interval where there is one trajectory."""

    value: float
    interval: Interval | None


@dataclass(frozen=True, kw_only=True)
class Point:
    """Error on one kind of pictures."""

    pictures: str  # a key of `ALL_TITLES`
    trajectory_count: int
    clip_count: int  # trajectories, in each of their appearances
    joint_rad: Mean
    openness: Mean
    hold_joint_rad: float  # of standing still, on the same frames
    hold_openness: float
    joint_change_rad: Mean | None  # against the same trajectories in a look of training
    openness_change: Mean | None


def measure(errors: pd.DataFrame, seed: int) -> list[Point]:
    """A point per kind of pictures, in the order of `ALL_TITLES`; appearances of a trajectory are averaged first."""
    keys = ["garment", "trajectory", "seed"]
    known = [name for name in ALL_TITLES if name in set(errors["pictures"])]
    tables = {
        name: errors[errors["pictures"] == name].groupby(keys, as_index=False).mean(numeric_only=True) for name in known
    }
    clips = errors.drop_duplicates(["pictures", "garment", "trajectory", "appearance"])["pictures"].value_counts()
    return [_point(name, int(clips[name]), tables, seed) for name in known]


def read_points(artifact: Path) -> list[Point]:
    """The points in `image_policy.json`.

    Raises:
        BadInput: missing, damaged, or of another version.
    """
    found = read_figures(artifact / "image_policy.json", SCHEMA, "image_policy")
    try:
        return pydantic.TypeAdapter(list[Point]).validate_python(found.get("points"))
    except pydantic.ValidationError as error:
        raise BadInput(f"{artifact}/image_policy.json: points: {explained(error)}; make image_policy again") from error


def _point(name: str, clip_count: int, tables: Mapping[str, pd.DataFrame], seed: int) -> Point:
    own = tables[name]
    joint, openness = (error_table(own, column) for column in ERRORS)
    changes: list[Mean | None] = [None, None]
    if name not in (DATASET, IN_DOMAIN):
        before = [error_table(tables[IN_DOMAIN], column) for column in ERRORS]  # of the same trajectories
        changes = [
            _mean(now - then, seed, name, "change", column)
            for now, then, column in zip((joint, openness), before, ERRORS)
        ]
    return Point(
        pictures=name,
        trajectory_count=len(joint),
        clip_count=clip_count,
        joint_rad=_mean(joint, seed, name, "joint"),
        openness=_mean(openness, seed, name, "openness"),
        hold_joint_rad=float(own["hold_joint_error_rad"].mean()),
        hold_openness=float(own["hold_openness_error"].mean()),
        joint_change_rad=changes[0],
        openness_change=changes[1],
    )


def _mean(table: np.ndarray, seed: int, *names: str) -> Mean:
    """Of errors (t, s) by trajectory and network."""
    return Mean(value=float(table.mean()), interval=interval_of(table, random_stream(seed, "image", *names)))


def of_pictures(points: Sequence[Point], name: str) -> Point | None:
    """The point of one kind of pictures, where it was measured."""
    return next((point for point in points if point.pictures == name), None)
