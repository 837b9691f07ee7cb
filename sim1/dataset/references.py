"""What an episode of the dataset is held to later: moments of the simulation's own file and of its rendered frames.

They are read from the source beside what LeRobot's writer is handed, so that a fault on the way into the dataset shows. Ends alone
would not do: every episode begins and ends with the arms at home, so moments between are kept too, and where the garment was.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from PIL import Image

from sim1.dataset.sources import RenderedClip
from sim1.episode import Episode
from sim1.stage import BadInput

MOMENTS = 5  # first and last frame, and as evenly as may be between
THUMBNAIL = (16, 12)  # pixels; enough to tell where arms and garment are, whatever the codec did to details
COLUMNS = (
    "frame_count",
    "reference_frames",
    "reference_states",
    "reference_actions",
    "reference_keypoints_m",
    "reference_thumbnails",
    "cameras",
)


@dataclass(frozen=True, kw_only=True)
class References:
    """Of one episode, k of its frames."""

    frames: np.ndarray  # (k,) int, counted in the dataset's frames
    states: np.ndarray  # (k, n)
    actions: np.ndarray  # (k, n)
    keypoints_m: np.ndarray  # (k, 3 * keypoints), world frame
    thumbnails: dict[str, np.ndarray]  # camera -> (k, h * w * 3) grey levels

    @classmethod
    def of_row(cls, row: dict[str, Any], cameras: list[str]) -> Self:
        """Of a row of provenance.

        Args:
            row: by column, see `COLUMNS`.
            cameras: names in the row's column `cameras`.

        Raises:
            BadInput: a column does not hold so many numbers for each frame.
        """
        frames = np.array(row["reference_frames"], int)
        if not len(frames) or frames.min() < 0 or frames.max() >= row["frame_count"]:
            raise BadInput(f"reference_frames are {frames.tolist()}, of {row['frame_count']} frames")
        pictures = _rows(row, "reference_thumbnails", len(frames) * len(cameras))
        return cls(
            frames=frames,
            states=_rows(row, "reference_states", len(frames)),
            actions=_rows(row, "reference_actions", len(frames)),
            keypoints_m=_rows(row, "reference_keypoints_m", len(frames)),
            thumbnails=dict(zip(sorted(cameras), np.split(pictures, len(cameras) or 1))),
        )


def moments(frame_count: int) -> list[int]:
    """Frames to keep of so many, in order, first and last among them."""
    return sorted({int(frame) for frame in np.linspace(0, frame_count - 1, MOMENTS).round()})


def thumbnail(image: np.ndarray) -> list[int]:
    """A frame (h, w, 3) u8 reduced to a few block means, flattened."""
    return np.asarray(Image.fromarray(image).resize(THUMBNAIL, Image.Resampling.BOX)).ravel().tolist()


def reference_columns(clip: RenderedClip, episode: Episode, keypoints: np.ndarray) -> dict[str, Any]:
    """Columns of provenance, arrays flattened; `episode_sha256` finds the file again, whatever it is called by then.

    Args:
        clip: whose frames are shown.
        episode: what the simulation recorded.
        keypoints: (k,) vertices.
    """
    frames = moments(clip.about["frame_count"])
    at = [frame * clip.stride for frame in frames]
    pictures = [
        thumbnail(np.asarray(Image.open(clip.frames(camera)[frame]).convert("RGB")))
        for camera in sorted(clip.cameras)
        for frame in frames
    ]
    return {
        "episode_sha256": digest(clip.episode / "episode.npz"),
        "reference_frames": frames,
        "reference_states": episode.state()[at].ravel().tolist(),
        "reference_actions": episode.action_until_next(clip.stride)[frames].ravel().tolist(),
        "reference_keypoints_m": episode.garment_m[at][:, keypoints].astype(np.float32).ravel().tolist(),
        "reference_thumbnails": np.ravel(pictures).tolist(),
    }


def digest(path: Path) -> str:
    """SHA-256 of a file, hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _rows(row: dict[str, Any], name: str, count: int) -> np.ndarray:
    values = np.array(row[name], float)
    if values.ndim != 1 or (values.size % count if count else values.size):
        raise BadInput(f"{name} has {values.size} values, no multiple of {count}")
    return values.reshape(count, -1) if count else values.reshape(0, 0)
