"""A small artifact of rendered episodes, its frames painted instead of rendered."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from sim1.dataset.stage import DatasetConfig, dataset
from sim1.episode import RATE_HZ, Episode, write_episode
from sim1.render.appearance import SCHEMA

WIDTH, HEIGHT, STRIDE, VERTICES = 64, 48, 3, 40
ROBOT = {"": Path(__file__).parents[2] / "data" / "robot"}
TASK = "turn the towel over"
LOOK = {"fabric": {"name": "denim"}, "table": {"name": "walnut"}, "room": {"name": "office-low_sun-grey_carpet"}}


def frame_image(number: int, hue: int) -> np.ndarray:
    """A smooth picture in which a bright bar moves with the frame's number."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    image = np.stack([60 + x, 60 + 2 * y, np.full_like(x, hue)], axis=-1).astype(np.uint8)
    image[10:30, 6 * number : 6 * number + 8] = (230, 230, 40)
    return image


def make_episode(frame_count: int, seed: int) -> Episode:
    stream = np.random.default_rng(seed)
    joints = stream.uniform(0.1, 1.25, (1, 2, 6)) + 0.01 * np.arange(frame_count)[:, None, None]
    openness = stream.uniform(0.2, 0.8, (frame_count, 2))
    garment = stream.normal(0.0, 0.2, (1, VERTICES, 3)) + 0.002 * np.arange(frame_count)[:, None, None]
    about = {
        "garment": "towel",
        "task_text": TASK,
        "seed": seed,
        "sources": [f"{seed:04d}"],
        "success": True,
    }
    return Episode(
        time_s=np.arange(frame_count) / RATE_HZ,
        joints_rad=joints,
        openness=openness,
        command_joints_rad=joints + 0.005,
        command_openness=openness,
        garment_m=garment.astype(np.float32),
        about=about,
    )


def painted(frame: int, number: int, variant: int, camera: str) -> np.ndarray:
    return frame_image(frame, hue=60 + 100 * variant + 50 * number)


def seen_by(camera: str, size: tuple[int, int]) -> dict:
    """A camera of `appearance.json`: a metre above the table, looking straight down, or on a wrist."""
    pose = np.eye(4)
    pose[2, 3] = 1.0
    moves = camera != "head"
    return {"width": size[0], "height": size[1], "fy_px": 40.0, "camera_to_world": pose.tolist(), "moves": moves}


def write_rendered(
    artifact: Path,
    *,
    frame_counts: tuple[int, ...] = (19, 25),
    variants: int = 1,
    rate_hz: int = 10,
    size=(WIDTH, HEIGHT),
    cameras: tuple[str, ...] = ("head",),
    make: Callable[[int, int], Episode] = make_episode,
    paint: Callable[[int, int, int, str], np.ndarray] = painted,
) -> Path:
    """An artifact of `rendered_episodes` with episodes of that many states.

    `make` is given frame count and number of an episode, `paint` frame, number, variant and camera.
    """
    artifact.mkdir(parents=True)
    np.savez(
        artifact / "garment.npz",
        rest_m=np.random.default_rng(9).normal(size=(VERTICES, 3)),
        faces=np.zeros((0, 3), int),
    )
    for number, frame_count in enumerate(frame_counts):
        folder = artifact / "episodes" / f"{number:04d}"
        write_episode(folder, make(frame_count, number))
        shown = len(range(0, frame_count, STRIDE))
        for variant in range(variants):
            clip = folder / f"v{variant}"
            clip.mkdir()
            about = {
                "schema": SCHEMA,
                "rate_hz": rate_hz,
                "stride": STRIDE,
                "frame_count": shown,
                "cameras": {name: seen_by(name, size) for name in cameras},
                "appearance": LOOK,
            }
            (clip / "appearance.json").write_text(json.dumps(about))
            for camera in cameras:
                (clip / camera).mkdir()
                for frame in range(shown):
                    image = Image.fromarray(paint(frame, number, variant, camera)).resize(size)
                    image.save(clip / camera / f"{frame:06d}.png")
    return artifact


def written_dataset(folder: Path, frame_counts: tuple[int, ...]) -> Path:
    """The artifact `dataset` of one appearance of each of these trajectories."""
    out = folder / "whole"
    out.mkdir()
    rendered = write_rendered(folder / "towel", variants=1, frame_counts=frame_counts)
    dataset({"robot": ROBOT, "rendered_episodes": {"towel": rendered}}, out, DatasetConfig(keypoint_count=5))
    return out
