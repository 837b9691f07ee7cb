"""Error of an image policy's chunks on trajectories that it has not seen, given the recorded pictures and states."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lerobot.utils.random_utils import seeded_context

from sim1.policy.image.build import Trained
from sim1.policy.image.clips import Clip
from sim1.policy.image.frames import Batch, loader, open_frames, seen_by
from sim1.policy.training import chunk_error, one_thread
from sim1.progress import report

ERROR_COLUMNS = (
    "pictures", "garment", "trajectory", "appearance", "frame_count",
    "joint_error_rad", "openness_error", "hold_joint_error_rad", "hold_openness_error",
)  # fmt: skip

type See = Callable[[Batch], Batch]
"""What becomes of a batch before the policy sees it."""


def errors_of(
    trained: Trained,
    dataset: Path,
    clips: Mapping[str, Sequence[Clip]],
    *,
    chunk_frames: int,
    every: int,
    stride: int = 1,
    batch: int,
    workers: int,
    seed: int,
    see: See = dict,
) -> list[dict[str, Any]]:
    """One row per clip, see `ERROR_COLUMNS`; the error of a chunk is that of its first `chunk_frames` commands.

    Args:
        trained: the policy.
        dataset: folder with `lerobot/`.
        clips: what the pictures show -> episodes of that dataset.
        chunk_frames: compared commands per frame, the recorded ones being held at the end as the state policy's are.
        every: only every so many frames of a trajectory are tried, the first included.
        stride: frames of a trajectory for one of its clips; divides `every`.
        batch: frames at once.
        workers: processes that decode videos.
        seed: of policies that answer by chance.
        see: changes what is seen.
    """
    named = [(name, clip) for name, own in clips.items() for clip in own]
    if not named:
        return []
    frames = open_frames(dataset, [clip.episode_index for _, clip in named], trained.policy.config, commands=False)
    wanted = [_places(frames, clip, every // stride) for _, clip in named]
    chosen = torch.utils.data.Subset(frames, [place for places in wanted for place in places])
    said = []
    with one_thread(), seeded_context(seed):
        batches = loader(chosen, batch_size=batch, shuffle=False, num_workers=workers)
        for done, read in enumerate(batches):
            report(done, len(batches), "frames of held-out trajectories")
            seen = see(seen_by(trained.policy.config, read, commands=False))
            said.append(trained.answer(seen)[:, :chunk_frames])
    parts = np.split(np.concatenate(said), np.cumsum([len(places) for places in wanted])[:-1])
    return [
        {
            "pictures": name,
            "garment": clip.trajectory.garment,
            "trajectory": clip.trajectory.name,
            "appearance": clip.appearance,
            "frame_count": len(part),
            **asdict(chunk_error(part, clip.trajectory, every)),
        }
        for (name, clip), part in zip(named, parts, strict=True)
    ]


def without_pictures(colors: Mapping[str, np.ndarray]) -> See:
    """Every picture becomes one colour, (3, 1, 1) by camera: what does the policy know without looking?"""

    def see(batch: Batch) -> Batch:
        flat = {
            name: torch.as_tensor(color, dtype=batch[name].dtype).expand_as(batch[name])
            for name, color in colors.items()
        }
        return {**batch, **flat}

    return see


def _places(frames: Any, clip: Clip, every: int) -> range:
    """Places of a clip's frames in an opened dataset."""
    row = frames.meta.episodes[clip.episode_index]
    first = frames.absolute_to_relative_idx[row["dataset_from_index"]]
    return range(first, first + row["dataset_to_index"] - row["dataset_from_index"], every)
