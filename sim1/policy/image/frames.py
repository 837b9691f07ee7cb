"""Reads a LeRobot dataset for a policy, and what its training part is like."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import torch
from lerobot.configs import PolicyFeature, PreTrainedConfig
from lerobot.datasets.compute_stats import aggregate_stats
from lerobot.datasets.dataset_metadata import LeRobotDatasetMetadata
from lerobot.datasets.factory import resolve_delta_timestamps
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.utils.feature_utils import dataset_to_policy_features

from sim1.dataset.quiet import quiet_libraries
from sim1.dataset.stage import NAME
from sim1.policy.episodes import ACTION
from sim1.stage import BadInput

type Batch = dict[str, Any]
type Statistics = dict[str, dict[str, np.ndarray]]  # column -> mean, std, min, max, count, quantiles


def read_features(dataset: Path) -> dict[str, PolicyFeature]:
    """Every column of a `dataset` artifact that a policy could see or say, by name.

    Raises:
        BadInput: the dataset's description is missing or damaged.
    """
    try:
        return dataset_to_policy_features(LeRobotDatasetMetadata(NAME, dataset / "lerobot").features)
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"{dataset}/lerobot/meta: not readable ({error}); make the dataset again") from error


def open_frames(
    dataset: Path, episodes: Sequence[int], config: PreTrainedConfig, *, commands: bool = True
) -> LeRobotDataset:
    """The frames of some episodes with as much of the past as the policy asks for and, if wanted, the commands to come."""
    root = dataset / "lerobot"
    with quiet_libraries():
        steps = resolve_delta_timestamps(config, LeRobotDatasetMetadata(NAME, root)) or {}
        if not commands:
            steps = {name: times for name, times in steps.items() if name != ACTION}
        return LeRobotDataset(
            NAME, root=root, episodes=sorted(episodes), delta_timestamps=steps or None, video_backend="pyav"
        )


def looks_back(config: PreTrainedConfig) -> bool:
    """Does the policy see frames before the current one?"""
    return any(step != 0 for step in config.observation_delta_indices or ())


def seen_by(config: PreTrainedConfig, batch: Mapping[str, Any], *, commands: bool = True) -> Batch:
    """The part of a batch that a policy may see: its own inputs, the task, commands to learn. Nothing privileged passes."""
    known = {*config.input_features, "task", *(f"{name}_is_pad" for name in config.input_features)}
    if commands:
        known |= {ACTION, f"{ACTION}_is_pad"}
    return {name: value for name, value in batch.items() if name in known}


def training_statistics(dataset: Path, episodes: Sequence[int]) -> Statistics:
    """Mean, spread, range and quantiles of every column over some episodes alone, from what LeRobot noted of each.

    Raises:
        BadInput: the dataset has no such notes.
    """
    wanted, found = set(episodes), []
    for path in sorted((dataset / "lerobot" / "meta" / "episodes").rglob("*.parquet")):
        names = pq.read_schema(path).names
        columns = ["episode_index", *(name for name in names if name.startswith("stats/"))]
        for row in pq.read_table(path, columns=columns).to_pylist():
            if row.pop("episode_index") in wanted:
                found.append(_unflattened(row))
    if len(found) != len(wanted) or not all(found):
        raise BadInput(
            f"{dataset}/lerobot/meta/episodes: statistics of {len(found)} of {len(wanted)} episodes; make the dataset again"
        )
    whole = aggregate_stats(found)
    return {feature: dict(sorted(whole[feature].items())) for feature in sorted(whole)}


class KeptFrames(torch.utils.data.Dataset):
    """Frames that are read, and their videos decoded, once: afterwards they come from memory, the same to the bit.

    A picture of numbers from 0 to 1 is kept as the bytes that lerobot made these of, any other as it is. What finds no
    room is read again each time. Every process that loads frames keeps its own.
    """

    def __init__(self, frames: LeRobotDataset, room_bytes: int) -> None:
        self._frames, self._room_bytes = frames, room_bytes
        self._kept: dict[int, tuple[Batch, dict[str, torch.Tensor]]] = {}

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: int) -> Batch:
        if index in self._kept:
            rest, pictures = self._kept[index]
            return rest | {name: picture.float() / 255 for name, picture in pictures.items()}
        frame = self._frames[index]
        if self._room_bytes > 0:
            pictures = {name: found for name, value in frame.items() if (found := _as_bytes(value)) is not None}
            rest = {name: value for name, value in frame.items() if name not in pictures}
            size = sum(
                value.nbytes for value in (*rest.values(), *pictures.values()) if isinstance(value, torch.Tensor)
            )
            if size <= self._room_bytes:
                self._room_bytes -= size
                self._kept[index] = rest, pictures
        return frame


def loader(frames: torch.utils.data.Dataset, **options: Any) -> torch.utils.data.DataLoader:
    """Batches of frames; a generator of its own keeps torch's random state out of it, so that a resumed run draws the same.

    Worker processes, where `options` ask for some, are spawned: a fork of a process that has decoded videos may hang.
    """
    context = "spawn" if options.get("num_workers") else None
    return torch.utils.data.DataLoader(frames, generator=torch.Generator(), multiprocessing_context=context, **options)


def _as_bytes(value: Any) -> torch.Tensor | None:
    """Bytes that say the same as a picture's numbers from 0 to 1, (..., channels, rows, columns); None of anything else."""
    if not isinstance(value, torch.Tensor) or value.dtype != torch.float32 or value.ndim < 3:
        return None
    packed = (255 * value).round().to(torch.uint8)
    return packed if torch.equal(packed.float() / 255, value) else None


def _unflattened(row: Mapping[str, Any]) -> Statistics:
    statistics: Statistics = {}
    for name, value in row.items():
        feature, _, statistic = name.removeprefix("stats/").rpartition("/")
        statistics.setdefault(feature, {})[statistic] = np.array(value)
    return statistics
