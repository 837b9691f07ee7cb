"""One recorded run of the robot cell, demonstrated, generated or rolled out by a policy.

An episode is a folder with `episode.npz` (time series at `RATE_HZ`) and `episode.json` (where it came from, how it went).
"""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from sim1.array_file import Shape, read_numbers
from sim1.stage import BadInput

RATE_HZ = 30.0
ARMS = ("left", "right")
JOINT_COUNT = 6
SCHEMA = "sim1.episode/1"
STATE_NAMES = [  # of `Episode.state` and `Episode.action`
    name for arm in ARMS for name in (*(f"{arm}_joint_{j + 1}_rad" for j in range(JOINT_COUNT)), f"{arm}_openness")
]


@dataclass(frozen=True, kw_only=True)
class Episode:
    """A run of the cell; T frames, arms in the order of `ARMS`."""

    time_s: np.ndarray  # (T,) from 0, step 1 / RATE_HZ
    joints_rad: np.ndarray  # (T, 2, 6) measured
    openness: np.ndarray  # (T, 2) in [0, 1], 1 is open
    command_joints_rad: np.ndarray  # (T, 2, 6) what the controller asked for at that frame
    command_openness: np.ndarray  # (T, 2)
    garment_m: np.ndarray  # (T, V, 3) float32, vertices of the garment mesh, world frame
    about: dict[str, Any] = field(default_factory=dict)  # JSON: garment, kind, seed, sources, success, failure, ...

    @property
    def frame_count(self) -> int:
        return len(self.time_s)

    def state(self) -> np.ndarray:
        """Left joints, left openness, right joints, right openness: (T, 14) float32."""
        return _pack(self.joints_rad, self.openness)

    def action(self) -> np.ndarray:
        """Commanded counterpart of `state`: (T, 14) float32."""
        return _pack(self.command_joints_rad, self.command_openness)

    def action_until_next(self, stride: int) -> np.ndarray:
        """What to command in every `stride`-th frame to get to the state of the next of these: (ceil(T / stride), 14) float32.

        That is the command of the last frame before it; a frame's own command leads 1 / `RATE_HZ` s ahead, and who follows it at
        a lower rate comes late. Behind the last kept frame it is the episode's last one.
        """
        last_before = np.arange(stride - 1, self.frame_count + stride - 1, stride)
        return self.action()[np.minimum(last_before, self.frame_count - 1)]


def _pack(joints: np.ndarray, openness: np.ndarray) -> np.ndarray:
    return np.concatenate([joints, openness[..., None]], axis=-1).reshape(len(joints), -1).astype(np.float32)


_ARRAYS: dict[str, Shape] = {
    "time_s": ("frames",),
    "joints_rad": ("frames", len(ARMS), JOINT_COUNT),
    "openness": ("frames", len(ARMS)),
    "command_joints_rad": ("frames", len(ARMS), JOINT_COUNT),
    "command_openness": ("frames", len(ARMS)),
    "garment_m": ("frames", "vertices", 3),
}


def write_episode(folder: Path, episode: Episode) -> None:
    """Write `episode.npz` and `episode.json` into `folder` (made if missing)."""
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {name: getattr(episode, name) for name in _ARRAYS}
    arrays["garment_m"] = arrays["garment_m"].astype(np.float32)
    np.savez(folder / "episode.npz", **arrays)
    about = {"schema": SCHEMA, **episode.about}
    (folder / "episode.json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")


def read_episode(folder: Path) -> Episode:
    """Read and check an episode.

    Raises:
        BadInput: a file is missing, damaged, or its arrays do not fit together.
    """
    path = folder / "episode.json"
    try:
        about = json.loads(path.read_text())
        schema = about["schema"]
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{path}: not a readable episode ({error!r}); make it again") from error
    if schema != SCHEMA:
        raise BadInput(f"{path}: schema is {schema!r}, expected {SCHEMA!r}; make it again")
    arrays = read_numbers(folder / "episode.npz", _ARRAYS, "episode")
    return Episode(**arrays, about={key: value for key, value in about.items() if key != "schema"})


def read_start(demos: Path) -> np.ndarray:
    """The garment settled on the table before anything moved, (v, 3) m, from an artifact of demonstrations.

    Raises:
        BadInput: `start.npz` is missing or damaged.
    """
    shapes: dict[str, Shape] = {"garment_m": ("vertices", 3)}
    arrays = read_numbers(demos / "start.npz", shapes, "start", "make the demonstrations again")
    return arrays["garment_m"].astype(float)


def episode_folders(artifact: Path) -> list[Path]:
    """Folders of an artifact's episodes (`artifact/episodes/NNNN`), in order."""
    return sorted(path.parent for path in artifact.glob("episodes/*/episode.json"))
