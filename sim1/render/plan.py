"""Turns accepted trajectories, a garment and a scene into a job for Blender, and records what will be seen."""

import hashlib
import shutil
from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from sim1.episode import ARMS, RATE_HZ, episode_folders, read_episode
from sim1.render.appearance import SCHEMA, Appearance
from sim1.render.appearance_file import write_about
from sim1.render.cameras import raised
from sim1.render.frame import is_lit, read_frame
from sim1.render.job import SETTINGS, VIEW_TRANSFORM, Clip, Job, frame_path, write_cameras, write_motion
from sim1.render.looks.draw import draw_appearance, read_looks
from sim1.render.robot_visuals import link_motion, part_poses, robot_parts
from sim1.render.stage import RenderConfig
from sim1.robot.kinematics import Arm
from sim1.scene.description import Camera, Scene, read_scene
from sim1.stage import BadInput, random_stream

TEXTURE_PLACES = 4000  # of the garment, whose colours stand for its texture
TABLE_DROP_M = 0.003  # drawn that much lower: cloth that rests in the top by a contact radius would be hidden by it

type Choice = Callable[[str, np.ndarray], Sequence[Appearance]]
"""Appearances to render a trajectory in, by its name and sRGB colours (n, 3) of places of the garment's texture; none: it is not
rendered."""


def drawn(looks: Path, garment: str, config: RenderConfig) -> Choice:
    """`config.variants` appearances drawn from the files in a folder.

    Raises:
        BadInput: a file or an entry is at fault.
    """
    known = read_looks(looks)

    def choose(name: str, texture: np.ndarray) -> list[Appearance]:
        return [
            draw_appearance(
                partial(random_stream, config.seed, "appearance", garment, name, variant),
                known,
                scanned=texture,
                scanned_share=config.scanned_share,
                elevation_jitter_rad=np.radians(config.elevation_jitter_deg),
            )
            for variant in range(config.variants)
        ]

    return choose


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
    world = read_scene(scene)
    cameras = _cameras(world, config, scene)
    arm = Arm.from_urdf(world.urdf)
    parts = robot_parts(arm)
    arrays, texture, places = _static(mesh, world)
    arrays |= {
        f"part_{i}_{key}": value
        for i, part in enumerate(parts)
        for key, value in (("vertices", part.vertices_m), ("faces", part.faces))
    }
    colors = [part.color for part in parts]
    still = _digest({**arrays, "part_colors": np.array(colors)}, texture)
    settings = _settings(config)
    clips = []
    for source in episode_folders(trajectories)[: config.max_episodes or None]:
        looks = choice(source.name, places)
        if not looks:
            continue
        episode = read_episode(source)
        if episode.garment_m.shape[1] != len(arrays["pattern_m"]):
            raise BadInput(
                f"{source}: {episode.garment_m.shape[1]} garment vertices, {mesh}/mesh.npz has {len(arrays['pattern_m'])}"
            )
        kept = slice(None, None, settings["stride"])
        links = link_motion(
            arm, world.base_to_world, joints_rad=episode.joints_rad[kept], openness=episode.openness[kept]
        )
        motion = {"garment_m": episode.garment_m[kept], "parts": part_poses(parts, links)}
        moving = _digest(motion)
        target = out / "episodes" / source.name
        target.mkdir(parents=True, exist_ok=True)
        for name in ("episode.npz", "episode.json"):
            shutil.copyfile(source / name, target / name)
        for variant, look in enumerate(looks):
            clip = Clip(
                episode=source.name,
                variant=variant,
                frame_count=len(links),
                stride=settings["stride"],
                appearance=look,
            )
            poses = _camera_poses(cameras, links, look.elevation_offset_rad, scene)
            # Frames of other meshes, colours or motions are not taken for these.
            shown = {"still": still, "moving": moving, "cameras": _digest(poses)}
            seen_by = _seen_by(cameras, poses, config)
            about = {
                **settings,
                "variant": clip.variant,
                "frame_count": clip.frame_count,
                "cameras": seen_by,
                "appearance": look.to_json(),
                "shown": shown,
            }
            write_about(out / clip.folder, about)
            _remove_faulty(out, clip, cameras, config)
            clips.append(clip)
            if not _is_whole(out, clip, cameras):
                # All episodes' motions together are larger than a memory; those that are rendered already are not needed.
                write_cameras(folder, clip, poses)
                write_motion(folder, clip, motion)
    _remove_others(out, clips)
    np.savez(out / "garment.npz", rest_m=arrays["rest_m"], faces=arrays["faces"])
    job = Job(
        folder=folder,
        texture=texture,
        settings={key: getattr(config, key) for key in SETTINGS},
        part_colors=colors,
        fy_over_height={name: camera.fy_px / camera.height for name, camera in cameras.items()},
        clips=clips,
    )
    job.write(arrays)
    return job


def _cameras(world: Scene, config: RenderConfig, scene: Path) -> dict[str, Camera]:
    known = {**world.cameras, **{f"{arm}_wrist": camera for arm, camera in world.wrist_cameras.items()}}
    if unknown := sorted(set(config.cameras) - set(known)):
        raise BadInput(f"{scene}/scene.json: no camera {', '.join(unknown)}; it has {', '.join(sorted(known))}")
    return {name: known[name] for name in config.cameras}


def _static(mesh: Path, world: Scene) -> tuple[dict[str, np.ndarray], Path, np.ndarray]:
    """Meshes that only change place, the texture's file, and its sRGB colours (n, 3) at places of the garment."""
    path = mesh / "mesh.npz"
    try:
        with np.load(path, allow_pickle=False) as data:
            rest_m, faces, uv = data["rest_m"], data["faces"], data["uv"]
        with Image.open(mesh / "texture.png") as image:
            texture = np.asarray(image.convert("RGB"), float) / 255.0
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"{mesh}: mesh.npz or texture.png is not readable ({error}); make garment_mesh again") from error
    if uv.shape != (*faces.shape, 2) or faces.min() < 0 or faces.max() >= len(rest_m):
        raise BadInput(
            f"{path}: faces {faces.shape} of {len(rest_m)} vertices with uv {uv.shape} do not fit; make garment_mesh again"
        )
    # Patterns lie in the plane in which the garment is largest, in metres.
    axes = np.sort(np.argsort(np.ptp(rest_m, axis=0))[-2:])
    table = trimesh.load(world.table_mesh, force="mesh")
    arrays = {
        "rest_m": rest_m,
        "faces": faces,
        "uv": uv,
        "pattern_m": rest_m[:, axes],
        "table_vertices": np.asarray(table.vertices) - [0.0, 0.0, TABLE_DROP_M],
        "table_faces": np.asarray(table.faces),
    }
    # What the garment shows, not the empty part of the texture chart.
    height, width, _ = texture.shape
    x = np.clip((uv[..., 0] * width).astype(int), 0, width - 1)
    y = np.clip(((1.0 - uv[..., 1]) * height).astype(int), 0, height - 1)
    places = texture[y, x].reshape(-1, 3)
    places = places[np.linspace(0, len(places) - 1, min(len(places), TEXTURE_PLACES)).astype(int)]
    return arrays, (mesh / "texture.png").resolve(), places


def _camera_poses(cameras: dict[str, Camera], links: list, elevation_rad: float, scene: Path) -> dict[str, np.ndarray]:
    """Camera -> camera_to_world (n, 4, 4); standing cameras are raised, those on a wrist move with it."""
    poses = {}
    for name, camera in cameras.items():
        if camera.link is None:
            pose = raised(camera.pose, elevation_rad, what=f"{scene}/scene.json: camera {name}")
            poses[name] = np.stack([pose] * len(links))
        else:
            arm = ARMS.index(name.removesuffix("_wrist"))
            poses[name] = np.stack([frame[arm][camera.link] @ camera.pose for frame in links])
    return poses


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
