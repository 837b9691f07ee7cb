"""Writes clips with LeRobot's own writer, the same bytes every time."""

import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from PIL import Image

from sim1.dataset.camera_models import camera_model
from sim1.dataset.decisions import scores
from sim1.dataset.keypoints import KEYPOINTS, keypoint_indices
from sim1.dataset.quiet import quiet_libraries
from sim1.dataset.references import reference_columns
from sim1.dataset.sources import RenderedClip
from sim1.dataset.stage import DatasetConfig
from sim1.episode import STATE_NAMES, Episode
from sim1.progress import track
from sim1.scene.description import Scene
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Known:
    """What is known of a garment's episodes beside what was rendered; None: nothing."""

    physics: dict[str, Any] | None = None  # JSON, see `known_physics`
    decisions: Mapping[str, dict[str, Any]] | None = None  # by trajectory, see `read_decisions`
    scene: Scene | None = None  # carries the cameras


def write_dataset(
    clips: list[RenderedClip], out: Path, config: DatasetConfig, *, name: str, known: Mapping[str, Known]
) -> pd.DataFrame:
    """Write `lerobot/`, `keypoints.json` and `provenance.parquet` into `out`. `known`: by garment.

    Returns:
        The provenance: one row per episode of the dataset, in its order.

    Raises:
        BadInput: the clips do not fit together.
    """
    from lerobot.configs.video import RGBEncoderConfig
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    rate_hz = _one("rate_hz", {clip.rate_hz for clip in clips})
    cameras = _one(
        "cameras", {tuple((key, c["height"], c["width"]) for key, c in sorted(clip.cameras.items())) for clip in clips}
    )
    if rate_hz != int(rate_hz):
        raise BadInput(f"rendered episodes: {rate_hz} Hz; LeRobot wants a whole number of frames per second")
    keypoints = {clip.garment: _keypoints(clip, config.keypoint_count) for clip in clips}
    # Without B-frames a frame's time stamp is its place in the file, also after episodes were joined. One thread, and no
    # macroblock tree, make x264's decisions the same every time: with the tree 8 of 700 encodings of the same small
    # frames differed, whatever the load; without it none of 2500 did.
    extra = {"bf": 0, "mbtree": 0} if config.codec == "h264" else {}
    encoder = RGBEncoderConfig(vcodec=config.codec, crf=config.crf, g=config.keyframe_interval, extra_options=extra)
    writer = LeRobotDataset.create(
        repo_id=name,
        fps=int(rate_hz),
        features=_features(cameras, config.keypoint_count),
        root=out / "lerobot",
        robot_type="arx_x5_dual",
        video_backend="pyav",
        rgb_encoder=encoder,
        encoder_threads=1,
    )
    rows = []
    with quiet_libraries():
        for index, clip in enumerate(track(clips, "episodes")):
            episode, chosen = clip.read_episode(), keypoints[clip.garment]
            task = _add_episode(writer, clip, episode, chosen)
            row = _provenance(clip, episode, known[clip.garment])
            references = reference_columns(clip, episode, chosen)
            rows.append({"episode_index": index, "task": task, **row, **references})
        writer.finalize()
    _sort_keys(
        out / "lerobot" / "meta" / "stats.json"
    )  # LeRobot goes through a set, so the order is that of its hashes
    shutil.rmtree(out / "lerobot" / "images", ignore_errors=True)  # staging folder of the encoder, empty by now
    text = {garment: [int(index) for index in chosen] for garment, chosen in sorted(keypoints.items())}
    (out / "keypoints.json").write_text(json.dumps(text, indent=1) + "\n")
    provenance = pd.DataFrame(rows)
    provenance.to_parquet(out / "provenance.parquet", index=False)
    return provenance


def _keypoints(clip: RenderedClip, count: int) -> np.ndarray:
    if (most := len(clip.rest_m)) < count:
        raise BadInput(
            f"{clip.mesh}: the mesh of {clip.garment} has {most} vertices, setting keypoint_count of stage dataset wants "
            f"{count}; set it to {most} at most, or make garment_mesh finer"
        )
    return keypoint_indices(clip.rest_m, count)


def _features(cameras: tuple[tuple[str, int, int], ...], keypoint_count: int) -> dict:
    state = {"dtype": "float32", "shape": (len(STATE_NAMES),), "names": STATE_NAMES}
    points = [f"garment_{index}_{axis}_m" for index in range(keypoint_count) for axis in "xyz"]
    images = {
        f"observation.images.{name}": {
            "dtype": "video",
            "shape": (height, width, 3),
            "names": ["height", "width", "channels"],
        }
        for name, height, width in cameras
    }
    return {
        "observation.state": state,
        "action": dict(state),
        KEYPOINTS: {"dtype": "float32", "shape": (len(points),), "names": points},
        **images,
    }


def _add_episode(writer, clip: RenderedClip, episode: Episode, keypoints: np.ndarray) -> str:
    """Append a clip; returns its task in words."""
    if episode.garment_m.shape[1] != len(clip.rest_m):
        raise BadInput(
            f"{clip.episode}: {episode.garment_m.shape[1]} garment vertices, its mesh has {len(clip.rest_m)}; render the episodes again"
        )
    kept = slice(None, None, clip.stride)
    states, points = episode.state()[kept], episode.garment_m[kept][:, keypoints]
    actions = episode.action_until_next(clip.stride)
    if len(states) != clip.about["frame_count"]:
        raise BadInput(
            f"{clip.folder}: {clip.about['frame_count']} frames for {len(states)} states; render the episodes again"
        )
    task = episode.about.get("task_text")
    if not isinstance(task, str):
        raise BadInput(
            f"{clip.episode}/episode.json: task_text is {task!r}, expected the task in words; make the episode again"
        )
    files = {camera: clip.frames(camera) for camera in sorted(clip.cameras)}
    for frame in range(len(states)):
        images = {camera: np.asarray(Image.open(paths[frame]).convert("RGB")) for camera, paths in files.items()}
        writer.add_frame(
            {
                "observation.state": states[frame],
                "action": actions[frame],
                KEYPOINTS: points[frame].astype(np.float32).ravel(),
                **{f"observation.images.{camera}": image for camera, image in images.items()},
                "task": task,
            }
        )
    writer.save_episode()
    return task


def _provenance(clip: RenderedClip, episode: Episode, known: Known) -> dict[str, Any]:
    """Where an episode comes from, by column."""
    about, decision = episode.about, None
    if known.decisions is not None:
        decision = known.decisions.get(clip.trajectory)
        if decision is None:
            raise BadInput(
                f"{clip.episode}: rendered, but valid_trajectories decided on no episode of that name; render the episodes again"
            )
    cameras = {name: camera_model(name, camera, known.scene) for name, camera in clip.cameras.items()}
    return {
        "garment": clip.garment,
        "trajectory": clip.trajectory,
        "appearance": clip.appearance,
        "sources": [str(source) for source in about.get("sources", [])],
        "frame_count": clip.about["frame_count"],
        "seed": json.dumps(about.get("seed")),
        "scores": json.dumps(scores(about, decision), sort_keys=True),
        "look": json.dumps(clip.about["appearance"], sort_keys=True),
        "cameras": json.dumps(cameras, sort_keys=True),
        "physics": json.dumps(known.physics, sort_keys=True),
        "about": json.dumps(about, sort_keys=True),  # everything the episode's file says
    }


def _sort_keys(path: Path) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()), indent=4, sort_keys=True) + "\n")


def _one(what: str, values: set):
    if len(values) != 1:
        raise BadInput(
            f"rendered episodes: {what} differ between garments: {sorted(values, key=str)}; render all with one profile"
        )
    return next(iter(values))
