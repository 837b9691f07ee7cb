"""Short videos of episodes in the head view, for the discriminator and for people."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim1.array_file import Shape, read_numbers
from sim1.episode import RATE_HZ
from sim1.stage import BadInput
from sim1.validity.raster import render_head_view

if TYPE_CHECKING:
    from sim1.scene.description import Scene


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A video of the head view."""

    frames: np.ndarray  # (t, h, w, 3) u8
    rate_hz: float


def head_clip(
    garment_m: np.ndarray, faces: np.ndarray, scene: Scene, *, rate_hz: float, width: int, height: int
) -> Clip:
    """Rasterised head view of an episode's garment (T, v, 3), the first and the last frame included."""
    count = max(round((len(garment_m) - 1) / RATE_HZ * rate_hz), 1) + 1
    picked = np.linspace(0, len(garment_m) - 1, count).round().astype(int)
    frames = [render_head_view(garment_m[frame], faces, scene, width, height) for frame in picked]
    return Clip(frames=np.stack(frames), rate_hz=rate_hz)


def write_clip(folder: Path, clip: Clip) -> None:
    """Write `video.npz`."""
    np.savez_compressed(folder / "video.npz", frames=clip.frames, rate_hz=np.float64(clip.rate_hz))


def read_clip(folder: Path) -> Clip:
    """Read `video.npz`.

    Raises:
        BadInput: missing, damaged, or not pictures.
    """
    path = folder / "video.npz"
    remedy = "make candidate_trajectories again"
    shapes: dict[str, Shape] = {"frames": ("frames", "rows", "columns", 3), "rate_hz": ()}
    arrays = read_numbers(path, shapes, "video", remedy)
    frames, rate = arrays["frames"], float(arrays["rate_hz"])
    if frames.dtype != np.uint8 or not frames.size:
        raise BadInput(f"{path}: array 'frames' is {frames.dtype} {frames.shape}, expected u8 (t, h, w, 3); {remedy}")
    return Clip(frames=frames, rate_hz=rate)


def sampled(frames: np.ndarray, count: int) -> np.ndarray:
    """At most `count` of frames (t, ...), spread evenly from the first to the last: (n, ...)."""
    if len(frames) <= count:
        return frames
    return frames[np.linspace(0, len(frames) - 1, count).round().astype(int)]
