"""Rendered episodes as real ones are: arms at home at both ends, and pictures of the ends that hardly differ."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
from rendered_towel import HEIGHT, ROBOT, STRIDE, TASK, VERTICES, WIDTH, write_rendered
from towel_cell import write_inputs

from sim1.dataset.stage import DatasetConfig, dataset
from sim1.episode import RATE_HZ, Episode
from sim1.stage import Inputs

HOME = np.array([0.0, 0.6, 0.6, -0.9, 0.0, 0.0])
FRAMES = 25  # of the simulation
SHOWN = len(range(0, FRAMES, STRIDE))
CAMERAS = ("head", "left_wrist", "right_wrist")
CONFIG = DatasetConfig(keypoint_count=4)


def fold(frame_count: int, number: int) -> Episode:
    """A fold from home to home; each number has its own reach, and its own place of the towel."""
    stream = np.random.default_rng(number)
    phase = np.linspace(0.0, 1.0, frame_count)[:, None, None]
    reach = np.sin(np.pi * phase) * stream.uniform(0.1, 0.3, (1, 2, 6))
    flat = np.random.default_rng(9).uniform(-0.2, 0.2, (VERTICES, 3)) * [1.0, 1.0, 0.0]
    placed = flat + np.array([*stream.uniform(-0.03, 0.03, 2), 0.002])
    folded = np.where(placed[:, :1] > 0.0, placed * [-1.0, 1.0, 2.0], placed)
    openness = 1.0 - 0.8 * np.sin(np.pi * phase[..., 0]) * np.ones((1, 2))
    return Episode(
        time_s=np.arange(frame_count) / RATE_HZ,
        joints_rad=HOME + reach,
        openness=openness,
        command_joints_rad=HOME + 0.99 * reach,
        command_openness=openness,
        garment_m=(placed + phase * (folded - placed)).astype(np.float32),
        about={
            "garment": "towel",
            "task_text": TASK,
            "seed": number,
            "sources": ["0000"],
            "success": True,
            "figures": {"iou": 0.9},
        },
    )


def picture(frame: int, number: int, variant: int, camera: str) -> np.ndarray:
    """A towel that gets a little shorter, and an arm that comes in and goes out again; all in the same look."""
    phase = frame / (SHOWN - 1)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    grain = np.random.default_rng(7).normal(0.0, 4.0, (HEIGHT, WIDTH, 1))
    image = np.stack([100 + x, 90 + y, 80 + x], axis=-1) + grain + 20.0 * CAMERAS.index(camera)
    image[14 + number : 34 + number, 16 : round(46 - 6 * phase) + number] += (25.0, 40.0, 15.0)
    reach = round(18 * np.sin(np.pi * phase)) + (2 * number if 0.0 < phase < 1.0 else 0)
    image[: 4 + reach, 28 + number : 36 + number] = (60.0, 62.0, 66.0)
    return np.clip(image, 0, 255).astype(np.uint8)


def rendered(folder: Path, make: Callable = fold, paint: Callable = picture, counts: tuple[int, ...] = (FRAMES,) * 3):
    return write_rendered(folder, frame_counts=counts, cameras=CAMERAS, make=make, paint=paint)


def decided(folder: Path) -> Path:
    """What the filters said of the three, in the words of `valid_trajectories`; the video abstains at the last."""
    folder.mkdir(parents=True)
    said = {"perturbed": False, "success": True, "failure": None, "rules_pass": True, "rules_broken": ""}
    rows = [
        {
            "episode": f"{n:04d}",
            **said,
            "video_score": None if n == 2 else 0.5 + n / 4,
            "video_pass": n < 2,
            "video_abstains": n == 2,
            "accepted": True,
        }
        for n in range(3)
    ]
    pd.DataFrame(rows).to_parquet(folder / "decisions.parquet", index=False)
    return folder


def written(folder: Path, source: Path) -> Path:
    """The dataset of these rendered episodes, with all that the pipeline knows of them."""
    (folder / "cell").mkdir(parents=True)
    inputs: Inputs = {
        "robot": ROBOT,
        "rendered_episodes": {"towel": source},
        "valid_trajectories": {"towel": decided(folder / "decided")},
        "scene": {"towel": write_inputs(folder / "cell")["scene"]["towel"]},
    }
    out = folder / "out"
    out.mkdir()
    dataset(inputs, out, CONFIG)
    return out


def column_of(artifact: Path, name: str) -> list:
    return [json.loads(text) for text in pd.read_parquet(artifact / "provenance.parquet")[name]]
