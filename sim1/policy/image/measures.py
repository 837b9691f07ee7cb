"""What the errors on held-out trajectories say, with intervals over trajectories."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pydantic

from sim1.data_file import explained
from sim1.policy.counting import read_figures
from sim1.policy.image.shifts import IN_DOMAIN, TITLES
from sim1.stage import BadInput, random_stream
from sim1.statistics import Interval, bootstrap_mean_interval

SCHEMA = "sim1.image_policy_result/2"  # of image_policy.json
DATASET, BLANK = "dataset", "no_picture"
ALL_TITLES = {DATASET: "as in the dataset", **TITLES, BLANK: "no picture, its mean colour"}


@dataclass(frozen=True, kw_only=True)
class Mean:
    """Mean over trajectories; no interval where there is one trajectory."""

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
    per_trajectory = errors.groupby(["pictures", "garment", "trajectory"]).mean(numeric_only=True)
    known = [name for name in ALL_TITLES if name in set(errors["pictures"])]
    return [_point(name, errors, per_trajectory, seed) for name in known]


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


def _point(name: str, errors: pd.DataFrame, per_trajectory: pd.DataFrame, seed: int) -> Point:
    own = per_trajectory.loc[name]
    changes: dict[str, Mean | None] = {"joint_error_rad": None, "openness_error": None}
    if name not in (DATASET, IN_DOMAIN):
        paired = own[list(changes)] - per_trajectory.loc[IN_DOMAIN][list(changes)]
        changes = {column: _mean(paired[column].to_numpy(), seed, name, "change", column) for column in changes}
    return Point(
        pictures=name,
        trajectory_count=len(own),
        clip_count=int((errors["pictures"] == name).sum()),
        joint_rad=_mean(own["joint_error_rad"].to_numpy(), seed, name, "joint"),
        openness=_mean(own["openness_error"].to_numpy(), seed, name, "openness"),
        hold_joint_rad=float(own["hold_joint_error_rad"].mean()),
        hold_openness=float(own["hold_openness_error"].mean()),
        joint_change_rad=changes["joint_error_rad"],
        openness_change=changes["openness_error"],
    )


def _mean(values: np.ndarray, seed: int, *names: str) -> Mean:
    interval = bootstrap_mean_interval(values, random_stream(seed, "image", *names)) if len(values) > 1 else None
    return Mean(value=float(values.mean()), interval=interval)


def of_pictures(points: Sequence[Point], name: str) -> Point | None:
    """The point of one kind of pictures, where it was measured."""
    return next((point for point in points if point.pictures == name), None)
