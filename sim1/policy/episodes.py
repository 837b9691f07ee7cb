"""Training trajectories of the state policy, read from a LeRobot dataset's tables."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sim1.dataset.keypoints import KEYPOINTS
from sim1.stage import BadInput

STATE = "observation.state"
ACTION = "action"
_COLUMNS = [STATE, KEYPOINTS, ACTION, "episode_index", "frame_index"]


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """What the state policy sees and does in one episode; T frames at the dataset's rate."""

    garment: str
    name: str  # folder of the accepted episode
    sources: frozenset[str]  # seed demonstrations that the motion came from
    state: np.ndarray  # (T, 14) joints [rad] and openness, left arm first
    keypoints: np.ndarray  # (T, 3 k) world positions of the garment's keypoints [m]
    action: np.ndarray  # (T, 14) what to command to get to the next frame's state


def read_trajectories(dataset: Path) -> list[Trajectory]:
    """Trajectories of a `dataset` artifact, one each even where it was rendered in several appearances.

    Raises:
        BadInput: files are missing or damaged, or the tables do not fit together.
    """
    files = sorted((dataset / "lerobot" / "data").rglob("*.parquet"))
    if not files:
        raise BadInput(f"{dataset}/lerobot/data: no parquet file; make the dataset again")
    try:
        frames = pd.concat([pd.read_parquet(path, columns=_COLUMNS) for path in files])
        provenance = pd.read_parquet(dataset / "provenance.parquet")
        rows = provenance[["episode_index", "garment", "trajectory", "appearance", "sources"]]
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{dataset}: not a readable dataset ({error}); make the dataset again") from error
    by_episode = dict(list(frames.sort_values("frame_index").groupby("episode_index")))
    unknown = sorted(set(by_episode) ^ set(rows["episode_index"]))
    if unknown:
        raise BadInput(f"{dataset}: episodes {unknown[:5]} are in only one of lerobot/data and provenance.parquet")
    first = rows.sort_values(["garment", "trajectory", "appearance"]).drop_duplicates(["garment", "trajectory"])
    return [_trajectory(row, by_episode[row.episode_index], dataset) for row in first.itertuples()]


def read_rate_hz(dataset: Path) -> int:
    """Frames per second of a `dataset` artifact."""
    return int(_json(dataset / "lerobot" / "meta" / "info.json", "fps"))


def read_keypoints(dataset: Path, garment: str) -> np.ndarray:
    """Vertices (k,) of the garment mesh whose positions are in the state."""
    return np.array(_json(dataset / "keypoints.json", garment), dtype=int)


def _json(path: Path, key: str) -> Any:
    try:
        return json.loads(path.read_text())[key]
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{path}: no readable {key!r} ({error!r}); make the dataset again") from error


def _trajectory(row: object, frames: pd.DataFrame, dataset: Path) -> Trajectory:
    arrays = {name: np.stack(frames[name].to_list()).astype(np.float32) for name in (STATE, KEYPOINTS, ACTION)}
    for name, array in arrays.items():
        if not np.isfinite(array).all():
            raise BadInput(f"{dataset}: episode {row.episode_index} has values in {name} that are not finite")
    return Trajectory(
        garment=str(row.garment),
        name=str(row.trajectory),
        sources=frozenset(str(source) for source in row.sources),
        state=arrays[STATE],
        keypoints=arrays[KEYPOINTS],
        action=arrays[ACTION],
    )
