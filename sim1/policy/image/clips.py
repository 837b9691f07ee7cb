"""Which episodes of the dataset train an image policy, and which are kept to test it."""

from dataclasses import dataclass
from pathlib import Path

from sim1.policy.counting import read_table
from sim1.policy.episodes import Trajectory, read_trajectories
from sim1.policy.split import GarmentSplit, split_by_garment
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Clip:
    """One episode of a LeRobot dataset: a trajectory in one appearance."""

    episode_index: int
    appearance: int
    trajectory: Trajectory


@dataclass(frozen=True, kw_only=True)
class Parts:
    """The dataset's episodes; all appearances of a trajectory are on one side."""

    train: list[Clip]
    held_out: list[Clip]
    splits: dict[str, GarmentSplit]  # by garment


def split_clips(dataset: Path, test_share: float, seed: int) -> Parts:
    """Split as the state policy does: by source demonstration, garment by garment, never by frame.

    The same seed and share hold out the same trajectories as stage `policy`, so their errors can be compared.

    Raises:
        BadInput: the dataset is damaged, or nothing is left to train on.
    """
    trajectories = read_trajectories(dataset)
    splits = split_by_garment(trajectories, test_share, seed)
    clips = clips_of(dataset, trajectories)
    tested = {(item.garment, item.name) for split in splits.values() for item in split.test}
    parts = Parts(
        train=[clip for clip in clips if (clip.trajectory.garment, clip.trajectory.name) not in tested],
        held_out=[clip for clip in clips if (clip.trajectory.garment, clip.trajectory.name) in tested],
        splits=splits,
    )
    if not parts.train:
        raise BadInput(f"{dataset}: no trajectory to train on; generate more")
    return parts


def clips_of(dataset: Path, trajectories: list[Trajectory]) -> list[Clip]:
    """Every episode of those trajectories in a folder with `lerobot/` and `provenance.parquet`, in the dataset's order."""
    known = {(item.garment, item.name): item for item in trajectories}
    rows = read_table(dataset / "provenance.parquet").sort_values("episode_index")
    return [
        Clip(
            episode_index=int(row.episode_index),
            appearance=int(row.appearance),
            trajectory=known[row.garment, row.trajectory],
        )
        for row in rows.itertuples()
        if (row.garment, row.trajectory) in known
    ]
