"""Held-out trajectories rendered anew in chosen looks, as a LeRobot dataset like the one that trains."""

import json
import shutil
import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from sim1.dataset.sources import read_clips
from sim1.dataset.stage import NAME, DatasetConfig
from sim1.dataset.write import Known, write_dataset
from sim1.policy.episodes import KEYPOINTS, Trajectory
from sim1.policy.image.clips import Clip
from sim1.policy.image.shifts import shifted_looks
from sim1.policy.image.trained_looks import about_clip, rendered_like
from sim1.progress import within
from sim1.render.appearance import Appearance
from sim1.render.blender import run_blender
from sim1.render.looks.draw import read_looks
from sim1.render.plan import plan_job
from sim1.scene.description import read_scene
from sim1.stage import BadInput, Inputs, only, random_stream

RENDERING_SHARE = 0.95  # of the progress; the rest is the video encoder's


def choose_trajectories(held_out: Sequence[Clip], count: int, first: Sequence[str]) -> list[Trajectory]:
    """At most `count` held-out trajectories, garments in turn: preferred ones first, then by name."""
    queues: dict[str, dict[str, Trajectory]] = {}
    for clip in held_out:
        queues.setdefault(clip.trajectory.garment, {})[clip.trajectory.name] = clip.trajectory
    garments = [*(name for name in first if name in queues), *sorted(queues.keys() - set(first))]
    ranked = [
        (turn, garments.index(name), item) for name in garments for turn, item in enumerate(queues[name].values())
    ]
    return [item for _, _, item in sorted(ranked, key=lambda row: row[:2])][:count]


def write_views(
    inputs: Inputs,
    chosen: Sequence[Trajectory],
    train: Sequence[Clip],
    out: Path,
    *,
    seed: int,
    viewpoint_rad: float,
    stride: int = 1,
) -> None:
    """Render each trajectory in every look of `shifts.TITLES` and write `out/views`, in the format of stage `dataset`.

    `appearance` in its provenance is the place of the look in `TITLES`. Size, samples and video codec are those of the
    dataset, so that what differs is the look. Frames are rendered into `out/frames`; those that an interrupted call
    left there are not rendered again.

    Args:
        inputs: with `dataset`, `rendered_episodes`, `garment_mesh`, `scene` and the files of looks, `appearance`.
        chosen: trajectories to render.
        train: clips whose looks are those of training.
        out: the artifact's folder.
        seed: of the choice among these looks, and of the new ones.
        viewpoint_rad: see `shifted_looks`.
        stride: only every so many frames of the dataset are rendered; divides its rate.

    Raises:
        BadInput: an input is missing or damaged.
        BlenderFailed: a process of Blender could not finish.
    """
    dataset, frames = inputs["dataset"][""], out / "frames"
    garments = sorted({item.garment for item in chosen})
    clips = []
    for place, garment in enumerate(garments):
        names = [item.name for item in chosen if item.garment == garment]
        with within(RENDERING_SHARE * place / len(garments), RENDERING_SHARE * (place + 1) / len(garments)):
            _render(inputs, garment, names, train, frames / garment, seed, viewpoint_rad, stride)
        clips += read_clips(frames / garment, garment)
    part = out / "views.part"
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir()
    with within(RENDERING_SHARE, 1.0):
        known = {garment: Known(scene=read_scene(inputs["scene"][garment])) for garment in garments}
        write_dataset(clips, part, _written_like(dataset), name=NAME, known=known)
    part.rename(out / "views")


def _render(
    inputs: Inputs,
    garment: str,
    names: Sequence[str],
    train: Sequence[Clip],
    out: Path,
    seed: int,
    viewpoint_rad: float,
    stride: int,
) -> None:
    for stage in ("rendered_episodes", "garment_mesh", "scene"):
        if garment not in inputs.get(stage, {}):
            raise BadInput(f"stage input {stage!r}: none for garment {garment!r}; materialize it first")
    rendered = inputs["rendered_episodes"][garment]
    trained = [
        about_clip(rendered, clip.trajectory.name, clip.appearance)
        for clip in train
        if clip.trajectory.garment == garment
    ]
    known, shown = read_looks(only(inputs, "appearance")), {}
    jitter_rad = np.radians(trained[0]["elevation_jitter_deg"])
    for name in names:
        seen = trained[int(random_stream(seed, "look", garment, name).integers(len(trained)))]
        base = TypeAdapter(Appearance).validate_python(seen["appearance"])
        chance = partial(random_stream, seed, "look", garment, name)
        looks = shifted_looks(base, chance, known, viewpoint_rad=viewpoint_rad, jitter_rad=jitter_rad)
        shown[name] = tuple(looks.values())
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        job = plan_job(
            trajectories=rendered,
            mesh=inputs["garment_mesh"][garment],
            scene=inputs["scene"][garment],
            choice=lambda name, mean: shown.get(name, ()),
            garment=garment,
            out=out,
            folder=Path(folder),
            config=rendered_like(trained[0], stride),
        )
        if job.frame_count:
            run_blender(Path(folder), out)


def _written_like(dataset: Path) -> DatasetConfig:
    """Settings of stage `dataset` as its artifact tells them."""
    path = dataset / "lerobot" / "meta" / "info.json"
    try:
        features = json.loads(path.read_text())["features"]
        video = next(item["info"] for _, item in sorted(features.items()) if item["dtype"] == "video")
        return DatasetConfig(
            keypoint_count=int(np.prod(features[KEYPOINTS]["shape"])) // 3,
            codec="h264" if video["video.codec"] == "h264" else "libsvtav1",
            crf=video["video.crf"],
            keyframe_interval=video["video.g"],
        )
    except (OSError, ValueError, KeyError, StopIteration) as error:
        raise BadInput(
            f"{path}: no readable features and video settings ({error!r}); make the dataset again"
        ) from error
