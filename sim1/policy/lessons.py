"""What policies learn from: growing parts of the generated trajectories, and of the demonstrations in either world."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sim1.episode import RATE_HZ, episode_folders, read_episode
from sim1.policy.episodes import Trajectory, read_keypoints, read_rate_hz, read_trajectories
from sim1.policy.split import GarmentSplit, nested_order, split_by_garment, usable_sizes
from sim1.policy.stage import PolicyConfig
from sim1.stage import BadInput, random_stream

GENERATED, SIMULATED, REAL = "generated", "simulated", "real"
KINDS = (GENERATED, SIMULATED, REAL)  # demonstrated in the simulator, and in the stand-in for reality
NAMES = {
    GENERATED: "generated trajectories",
    SIMULATED: "demonstrations in the simulator",
    REAL: "real demonstrations (stand-in)",
}


class ModelKey(NamedTuple):
    """One trained policy."""

    trained_on: str  # one of KINDS
    size: int  # trajectories
    seed: int

    @property
    def file(self) -> str:
        return f"{self.trained_on}_{self.size}_{self.seed}.safetensors"


@dataclass(frozen=True, kw_only=True)
class Lesson:
    """Trajectories of one kind: those of `train` may be in training sets, `held_out` are in none."""

    kind: str
    train: list[Trajectory]
    orders: Mapping[int, list[Trajectory]]  # network's seed -> all of `train`, in a random order of its own
    sizes: list[int]
    held_out: list[Trajectory]
    splits: Mapping[str, GarmentSplit]  # by garment that it shows

    def training_set(self, size: int, seed: int) -> list[Trajectory]:
        """What the network of a seed learns from, within what it learns from at a greater size.

        Seeds draw apart, so that networks of one size differ by which trajectories they were shown, too.
        """
        return self.orders[seed][:size]


def read_lessons(dataset: Path, demos: Mapping[str, Mapping[str, Path]], config: PolicyConfig) -> list[Lesson]:
    """The generated trajectories of a dataset, then demonstrations (artifacts by kind and garment), in the order of `KINDS`.

    Of those without sizes there are none, or nobody asks to learn from them.

    Raises:
        BadInput: files are damaged, or there is nothing to train on.
    """
    generated = read_trajectories(dataset)
    lessons = [_lesson(GENERATED, generated, config.sizes, config)]
    if not lessons[0].sizes:
        raise BadInput(f"{dataset}: no trajectory to train on; generate more, or ask for sizes of at least 1")
    known = {item.garment for item in generated}
    stride = round(RATE_HZ / read_rate_hz(dataset))
    for kind, sizes in ((SIMULATED, config.simulated_sizes), (REAL, config.real_sizes)):
        shown = [
            item
            for garment, folder in sorted(demos[kind].items())
            if garment in known
            for item in _demonstrations(folder, garment, read_keypoints(dataset, garment), stride, kind)
        ]
        lessons.append(_lesson(kind, shown, sizes, config))
    return lessons


def none_because(demos: Mapping[str, Path], sizes: Sequence[int]) -> str:
    """Why nobody learns from real demonstrations (artifacts by garment), in the words of who did not make them."""
    if not sizes:
        return "none were asked for"
    whys = {json.loads(path.read_text())["why"] for folder in demos.values() if (path := folder / "none.json").exists()}
    unfit = "none succeeded with a garment of the dataset" if demos else "none were made"
    return "; ".join(sorted(whys)) or unfit


def _lesson(kind: str, items: Sequence[Trajectory], sizes: Sequence[int], config: PolicyConfig) -> Lesson:
    splits = split_by_garment(items, config.test_share, config.seed)
    train = [item for split in splits.values() for item in split.train]
    return Lesson(
        kind=kind,
        train=train,
        orders={seed: nested_order(train, random_stream(config.seed, "order", seed)) for seed in config.seeds},
        sizes=usable_sizes(sizes, len(train), garment_count=len(splits)),
        held_out=[item for split in splits.values() for item in split.test],
        splits=splits,
    )


def _demonstrations(folder: Path, garment: str, keypoints: np.ndarray, stride: int, kind: str) -> list[Trajectory]:
    """Those that succeeded, at the dataset's rate."""
    found = []
    for path in episode_folders(folder):
        episode = read_episode(path)
        if not episode.about.get("success"):
            continue
        if episode.garment_m.shape[1] <= keypoints.max():
            raise BadInput(
                f"{path}: {episode.garment_m.shape[1]} garment vertices, the dataset has other meshes; make it again"
            )
        kept = slice(None, None, stride)
        points = episode.garment_m[kept][:, keypoints].astype(np.float32)
        found.append(
            Trajectory(
                garment=garment,
                name=path.name,
                sources=frozenset({f"{kind} {path.name}"}),
                state=episode.state()[kept],
                keypoints=points.reshape(len(points), -1),
                action=episode.action_until_next(stride),
            )
        )
    return found
