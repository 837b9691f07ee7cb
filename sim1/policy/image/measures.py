"""What the errors on held-out trajectories say, with intervals over their demonstrations and over networks."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
import pydantic

from sim1.data_file import explained
from sim1.policy.counting import read_figures
from sim1.policy.error_table import ErrorTable, error_table, interval_of
from sim1.policy.image.shifts import IN_DOMAIN, TITLES
from sim1.stage import BadInput, random_stream
from sim1.statistics import Interval

SCHEMA = "sim1.image_policy_result/4"  # of image_policy.json
DATASET, BLANK = "dataset", "no_picture"
ERRORS = ("joint_error_rad", "openness_error")  # columns
ALL_TITLES = {DATASET: "as in the dataset", **TITLES, BLANK: "no picture, its mean colour"}


@dataclass(frozen=True, kw_only=True)
class Mean:
    """Mean over trajectories and networks, with a bootstrap over the demonstrations of the former and over the latter.

    No interval where the trajectories come from one demonstration.
    """

    value: float
    interval: Interval | None


@dataclass(frozen=True, kw_only=True)
class Point:
    """Error on one kind of pictures."""

    pictures: str  # a key of `ALL_TITLES`
    trajectory_count: int
    source_count: int  # held-out demonstrations that these come from
    clip_count: int  # trajectories, in each of their appearances
    joint_rad: Mean
    openness: Mean
    hold_joint_rad: float  # of standing still, on the same frames
    hold_openness: float
    joint_change_rad: Mean | None  # against the same trajectories in a look of training
    openness_change: Mean | None


def measure(errors: pd.DataFrame, seed: int) -> list[Point]:
    """A point per kind of pictures, in the order of `ALL_TITLES`; appearances of a trajectory are averaged first."""
    keys = ["garment", "source", "trajectory", "seed"]
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
            _mean(replace(now, errors=now.errors - then.errors), seed, name, "change", column)
            for now, then, column in zip((joint, openness), before, ERRORS)
        ]
    return Point(
        pictures=name,
        trajectory_count=len(joint.sources),
        source_count=joint.source_count,
        clip_count=clip_count,
        joint_rad=_mean(joint, seed, name, "joint", least=0.0),
        openness=_mean(openness, seed, name, "openness", least=0.0),
        hold_joint_rad=float(own["hold_joint_error_rad"].mean()),
        hold_openness=float(own["hold_openness_error"].mean()),
        joint_change_rad=changes[0],
        openness_change=changes[1],
    )


def _mean(table: ErrorTable, seed: int, *names: str, least: float = -math.inf) -> Mean:
    """Of errors, or of changes of them; `least`: nothing is less."""
    return Mean(
        value=float(table.errors.mean()), interval=interval_of(table, random_stream(seed, "image", *names), least)
    )


def of_pictures(points: Sequence[Point], name: str) -> Point | None:
    """The point of one kind of pictures, where it was measured."""
    return next((point for point in points if point.pictures == name), None)
