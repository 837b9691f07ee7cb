"""What Blender's processes are asked to render: a folder with `job.json` and NPZ files, read back by `sim1.render.worker`."""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from sim1.render.appearance import Appearance, Color
from sim1.stage import random_stream

FRAME_NAME = "{:06d}.png"
# Of `RenderConfig`: what Blender's processes get to know.
SETTINGS = ("engine", "width", "height", "samples", "denoise", "workers", "threads", "device", "seed")
# How light becomes the grey levels of a picture: AgX stands for a camera's tone curve, Workbench's colours are meant for the screen.
VIEW_TRANSFORM = {"cycles": "AgX", "workbench": "Standard"}

type Picture = tuple[str, int]
"""Camera and frame number of one picture of a clip."""


@dataclass(frozen=True, kw_only=True)
class Clip:
    """One episode in one appearance."""

    garment: str = ""  # whose episode it is; a sheet of looks is nobody's
    episode: str  # name of the episode's folder
    variant: int
    frame_count: int
    stride: int  # states per frame
    appearance: Appearance

    @property
    def folder(self) -> str:
        """Where the frames go, relative to the artifact."""
        return f"episodes/{self.episode}/v{self.variant}"

    @property
    def key(self) -> str:
        return f"{self.episode}_v{self.variant}"


@dataclass(frozen=True, kw_only=True)
class Footage:
    """Where everything is that moves, in n states of the cell, world frame."""

    garment_m: np.ndarray  # (n, v, 3)
    parts: np.ndarray  # (n, p, 4, 4), of the robot
    cameras: dict[str, np.ndarray]  # camera -> camera_to_world (n, 4, 4)
    first: int = 0  # number that the first state has among the clip's frames

    @property
    def frame_count(self) -> int:
        return len(self.garment_m)

    @property
    def motion(self) -> dict[str, np.ndarray]:
        """What all appearances have in common; see `write_motion`."""
        return {"garment_m": self.garment_m, "parts": self.parts}

    def at(self, first: int, cameras: dict[str, np.ndarray]) -> "Footage":
        """The same states under other numbers, seen from elsewhere."""
        return replace(self, first=first, cameras=cameras)


@dataclass(frozen=True, kw_only=True)
class Job:
    """Everything that a rendering depends on."""

    folder: Path
    texture: Path
    settings: dict[str, Any]  # those named in SETTINGS
    part_colors: list[Color]
    fy_over_height: dict[str, float]  # camera -> focal length in image heights
    clips: list[Clip]

    @property
    def frame_count(self) -> int:
        return sum(clip.frame_count for clip in self.clips) * len(self.fy_over_height)

    def frames(self) -> Iterator[tuple[Clip, str, int]]:
        """Clip, camera and frame number of every picture, in the order of rendering."""
        for clip in self.clips:
            for frame in range(clip.frame_count):
                for camera in sorted(self.fy_over_height):
                    yield clip, camera, frame

    def missing(self, out: Path) -> dict[str, list[Picture]]:
        """Pictures that `out` does not hold, in the order of rendering, by the clip's key."""
        found: dict[str, list[Picture]] = {}
        for clip, camera, frame in self.frames():
            if not self.frame_path(out, clip, camera, frame).exists():
                found.setdefault(clip.key, []).append((camera, frame))
        return found

    def frame_path(self, out: Path, clip: Clip, camera: str, frame: int) -> Path:
        return frame_path(out, clip, camera, frame)

    def picture_seed(self, clip: Clip, camera: str, frame: int) -> int:
        """Seed of the sampling of one picture, in [0, 2**31).

        Each picture has noise of its own, or a policy would learn the pattern that all have in common; garments number
        their episodes alike. It is counted in states, such that a trajectory shown at a lower rate, or again in another
        look, has the same noise in the same moment.
        """
        stream = random_stream(self.settings["seed"], "noise", clip.garment, clip.episode, camera, frame * clip.stride)
        return int(stream.integers(2**31))

    def arrays(self) -> dict[str, np.ndarray]:
        """What does not move: meshes and pattern coordinates (see `RenderScene`)."""
        return _load(self.folder / "static.npz")

    def clip(self, key: str) -> Clip:
        """The clip with that key: of the job, or written beside it since, see `write_clip`."""
        for clip in self.clips:
            if clip.key == key:
                return clip
        return TypeAdapter(Clip).validate_json((self.folder / f"clip_{key}.json").read_text())

    def footage(self, clip: Clip) -> Footage:
        """A clip's frames: see `write_motion` and `write_cameras`."""
        motion = _load(self.folder / f"motion_{clip.episode}.npz")
        return Footage(**motion, cameras=_load(self.folder / f"cameras_{clip.key}.npz"))

    def moment(self, name: str) -> Footage:
        """What `write_moment` wrote."""
        arrays = _load(self.folder / name)
        motion = {key: arrays.pop(key) for key in ("garment_m", "parts")}
        return Footage(**motion, first=int(arrays.pop("first")), cameras=arrays)

    def write(self, arrays: dict[str, np.ndarray]) -> None:
        """Write everything but what moves, which `write_motion` and `write_cameras` write clip by clip; see `arrays`."""
        self.folder.mkdir(parents=True, exist_ok=True)
        np.savez(self.folder / "static.npz", **arrays)
        content = {key: value for key, value in asdict(self).items() if key != "folder"}
        (self.folder / "job.json").write_text(json.dumps({**content, "texture": str(self.texture)}, indent=1))

    @classmethod
    def read(cls, folder: Path) -> "Job":
        content = json.loads((folder / "job.json").read_text())
        return TypeAdapter(cls).validate_python({**content, "folder": folder})


def frame_path(out: Path, clip: Clip, camera: str, frame: int) -> Path:
    """Where a picture lies in the artifact `out`."""
    return out / clip.folder / camera / FRAME_NAME.format(frame)


def write_motion(folder: Path, clip: Clip, motion: dict[str, np.ndarray]) -> None:
    """Write what moves in a clip's episode into a job's folder: `garment_m` and `parts` of `Footage`."""
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / f"motion_{clip.episode}.npz", **motion)


def write_cameras(folder: Path, clip: Clip, poses: dict[str, np.ndarray]) -> None:
    """Write a clip's cameras into a job's folder: `cameras` of `Footage`."""
    folder.mkdir(parents=True, exist_ok=True)
    np.savez(folder / f"cameras_{clip.key}.npz", **poses)


def write_clip(folder: Path, clip: Clip) -> None:
    """Write a clip that the job did not know when its processes were started."""
    (folder / f"clip_{clip.key}.json").write_bytes(TypeAdapter(Clip).dump_json(clip))


def write_moment(folder: Path, name: str, footage: Footage) -> None:
    """Write states that an order shows in place of its clip's footage."""
    np.savez(folder / name, **footage.motion, first=footage.first, **footage.cameras)


def _load(path: Path) -> dict[str, np.ndarray]:
    with np.load(path, allow_pickle=False) as data:
        return {name: data[name] for name in data.files}
