"""Turns accepted trajectories, a garment and a scene into a job for Blender, and records what will be seen."""

import hashlib
import shutil
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from sim1.episode import RATE_HZ, episode_folders, read_episode
from sim1.render.appearance import SCHEMA, Appearance
from sim1.render.appearance_file import write_about
from sim1.render.film_set import FilmSet
from sim1.render.frame import is_lit, read_frame
from sim1.render.job import VIEW_TRANSFORM, Clip, Job, frame_path, write_cameras, write_motion
from sim1.render.looks.draw import draw_appearance, read_looks
from sim1.render.stage import RenderConfig
from sim1.scene.description import Camera
from sim1.stage import BadInput, random_stream

type Choice = Callable[[str, np.ndarray], Sequence[Appearance]]
"""Appearances to render a trajectory in, by its name and sRGB colours (n, 3) of places of the garment's texture; none: it is not
rendered."""


def drawn(looks: Path, garment: str, config: RenderConfig, again: Mapping[tuple[str, int], int]) -> Choice:
    """`config.variants` appearances drawn from the files in a folder; of `config.shared_looks`, where that is not 0.

    Args:
        looks: the folder.
        garment: whose episodes they are.
        config: seed and how many.
        again: trajectory and number of the appearance -> how often it is drawn anew, as the garment was not seen in what was drawn before.

    Raises:
        BadInput: a file or an entry is at fault.
    """
    known = read_looks(looks)

    def choose(name: str, texture: np.ndarray) -> list[Appearance]:
        return [
            draw_appearance(
                partial(
                    random_stream,
                    config.seed,
                    "appearance",
                    garment,
                    *_named(config, garment, name, variant, again),
                ),
                known,
                scanned=texture,
                scanned_share=config.scanned_share,
                elevation_jitter_rad=np.radians(config.elevation_jitter_deg),
            )
            for variant in range(config.variants)
        ]

    return choose


def _whose(config: RenderConfig, garment: str, name: str, variant: int) -> tuple[str | int, ...]:
    """What a draw is named by: the trajectory and the number of its appearance, or the shared look that falls to it."""
    if not config.shared_looks:
        return (name, variant)
    dealt = random_stream(config.seed, "shared look", garment, name, variant)
    return ("shared look", int(dealt.integers(config.shared_looks)))


def _named(
    config: RenderConfig, garment: str, name: str, variant: int, again: Mapping[tuple[str, int], int]
) -> tuple[str | int, ...]:
    """The same, and how often it is drawn anew: a look in which one trajectory's garment is not seen changes for all that share it."""
    whose = _whose(config, garment, name, variant)
    times = sum(count for clip, count in again.items() if _whose(config, garment, *clip) == whose)
    return (*whose, "again", times) if times else whose


def plan_job(
    *,
    trajectories: Path,
    mesh: Path,
    scene: Path,
    choice: Choice,
    garment: str,
    out: Path,
    folder: Path,
    config: RenderConfig,
) -> Job:
    """Write the job into `folder`, and copies of the episodes with every clip's `appearance.json` into `out`.

    What `out` holds of other episodes or appearances than those planned now is removed; frames of the same ones are kept.

    Raises:
        BadInput: an input is damaged, has no episode, or does not fit the others.
    """
    film_set = FilmSet.of(mesh, scene, config.cameras)
    arrays = film_set.arrays
    still = _digest({**arrays, "part_colors": np.array(film_set.part_colors)}, film_set.texture)
    settings = _settings(config)
    clips = []
    for source in episode_folders(trajectories)[: config.max_episodes or None]:
        looks = choice(source.name, film_set.texture_colors)
        if not looks:
            continue
        episode = read_episode(source)
        if episode.garment_m.shape[1] != len(arrays["pattern_m"]):
            raise BadInput(
                f"{source}: {episode.garment_m.shape[1]} garment vertices, {mesh}/mesh.npz has {len(arrays['pattern_m'])}"
            )
        kept = slice(None, None, settings["stride"])
        footage = film_set.film(
            garment_m=episode.garment_m[kept], joints_rad=episode.joints_rad[kept], openness=episode.openness[kept]
        )
        moving = _digest(footage.motion)
        target = out / "episodes" / source.name
        target.mkdir(parents=True, exist_ok=True)
        for name in ("episode.npz", "episode.json"):
            shutil.copyfile(source / name, target / name)
        for variant, look in enumerate(looks):
            cameras = film_set.raised(footage.cameras, look.elevation_offset_rad)
            clip = Clip(
                garment=garment,
                episode=source.name,
                variant=variant,
                frame_count=footage.frame_count,
                stride=settings["stride"],
                appearance=look,
            )
            # Frames of other meshes, colours or motions are not taken for these.
            shown = {"still": still, "moving": moving, "cameras": _digest(cameras)}
            seen_by = _seen_by(film_set.cameras, cameras, config)
            about = {
                **settings,
                "garment": garment,
                "variant": clip.variant,
                "frame_count": clip.frame_count,
                "cameras": seen_by,
                "appearance": look.to_json(),
                "shown": shown,
            }
            write_about(out / clip.folder, about)
            _remove_faulty(out, clip, film_set.cameras, config)
            clips.append(clip)
            if not _is_whole(out, clip, film_set.cameras):
                # All episodes' motions together are larger than a memory; those that are rendered already are not needed.
                write_cameras(folder, clip, cameras)
                write_motion(folder, clip, footage.motion)
    _remove_others(out, clips)
    np.savez(out / "garment.npz", rest_m=arrays["rest_m"], faces=arrays["faces"])
    return film_set.job(folder, clips, config)


def _settings(config: RenderConfig) -> dict[str, Any]:
    """What all clips have in common, for `appearance.json`."""
    return {
        "schema": SCHEMA,
        "rate_hz": config.rate_hz,
        "stride": round(RATE_HZ / config.rate_hz),
        **{
            key: getattr(config, key)
            for key in ("engine", "samples", "denoise", "device", "seed", "elevation_jitter_deg")
        },
        "view_transform": VIEW_TRANSFORM[config.engine],
        "blender": version("bpy"),
    }


def _seen_by(cameras: dict[str, Camera], poses: dict[str, np.ndarray], config: RenderConfig) -> dict[str, Any]:
    """Cameras for `appearance.json`."""
    return {
        name: {
            "width": config.width,
            "height": config.height,
            "fy_px": camera.fy_px * config.height / camera.height,
            # Of the first frame; a camera on a wrist moves from there.
            "camera_to_world": np.round(poses[name][0], 9).tolist(),
            "moves": camera.link is not None,
        }
        for name, camera in cameras.items()
    }


def _remove_faulty(out: Path, clip: Clip, cameras: dict[str, Camera], config: RenderConfig) -> None:
    """Remove frames that the stage's check would refuse: `out` may be a copy of what it refused, and they are rendered again."""
    for name in cameras:
        for path in (out / clip.folder / name).glob("*.png"):
            image = read_frame(path, width=config.width, height=config.height)
            if image is None or not is_lit(image):
                path.unlink()


def _is_whole(out: Path, clip: Clip, cameras: dict[str, Camera]) -> bool:
    return all(frame_path(out, clip, name, frame).exists() for name in cameras for frame in range(clip.frame_count))


def _remove_others(out: Path, clips: list[Clip]) -> None:
    """Remove episodes and appearances that are not planned: `out` may hold those of an earlier rendering."""
    planned = {out / clip.folder for clip in clips}
    for folder in [*out.glob("episodes/*/v*"), *out.glob("episodes/*")]:
        if folder.is_dir() and not any(path.is_relative_to(folder) for path in planned):
            shutil.rmtree(folder)


def _digest(arrays: dict[str, np.ndarray], *files: Path) -> str:
    """Fingerprint of arrays, their names, types and shapes included, and of files."""
    content = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        content.update(f"{name} {array.dtype.str} {array.shape} ".encode() + array.tobytes())
    for file in files:
        content.update(file.read_bytes())
    return content.hexdigest()[:16]
