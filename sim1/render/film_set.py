"""A garment's cell before the cameras: what does not move, and where everything else is in given states."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh

from sim1.episode import ARMS
from sim1.render.cameras import raised
from sim1.render.job import SETTINGS, Clip, Footage, Job
from sim1.render.robot_visuals import Part, link_motion, part_poses, robot_parts
from sim1.render.stage import RenderConfig
from sim1.robot.kinematics import Arm
from sim1.scene.description import Camera, Scene, read_scene
from sim1.scene.garment import read_textured
from sim1.stage import BadInput

TEXTURE_PLACES = 4000  # of the garment, whose colours stand for its texture
TABLE_DROP_M = 0.003  # drawn that much lower: cloth that rests in the top by a contact radius would be hidden by it


@dataclass(frozen=True, kw_only=True)
class FilmSet:
    """Read from artifacts of `garment_mesh` and `scene` by `of`."""

    path: Path  # of the scene, for messages
    scene: Scene
    cameras: dict[str, Camera]  # those that film
    arm: Arm
    parts: list[Part]
    arrays: dict[str, np.ndarray]  # see `RenderScene`
    texture: Path
    texture_colors: np.ndarray  # (n, 3) sRGB, at places of the garment

    @classmethod
    def of(cls, mesh: Path, scene: Path, cameras: Sequence[str]) -> "FilmSet":
        """The cell of a garment, filmed by some of its cameras.

        Raises:
            BadInput: an artifact is damaged, or has no such camera.
        """
        world = read_scene(scene)
        arm = Arm.from_urdf(world.urdf)
        parts = robot_parts(arm)
        arrays, texture, colors = _garment_and_table(mesh, world)
        arrays |= {
            f"part_{i}_{key}": value
            for i, part in enumerate(parts)
            for key, value in (("vertices", part.vertices_m), ("faces", part.faces))
        }
        return cls(
            path=scene,
            scene=world,
            cameras=_cameras(world, cameras, scene),
            arm=arm,
            parts=parts,
            arrays=arrays,
            texture=texture,
            texture_colors=colors,
        )

    @property
    def part_colors(self) -> list[tuple[float, float, float]]:
        return [part.color for part in self.parts]

    def film(self, *, garment_m: np.ndarray, joints_rad: np.ndarray, openness: np.ndarray) -> Footage:
        """Where everything is that moves, standing cameras where the scene has them.

        Args:
            garment_m: (n, v, 3).
            joints_rad: (n, 2, 6).
            openness: (n, 2).
        """
        links = link_motion(self.arm, self.scene.base_to_world, joints_rad=joints_rad, openness=openness)
        cameras = {}
        for name, camera in self.cameras.items():
            if camera.link is None:
                cameras[name] = np.stack([camera.pose] * len(links))
            else:
                arm = ARMS.index(name.removesuffix("_wrist"))
                cameras[name] = np.stack([frame[arm][camera.link] @ camera.pose for frame in links])
        return Footage(garment_m=garment_m, parts=part_poses(self.parts, links), cameras=cameras)

    def raised(self, poses: dict[str, np.ndarray], elevation_rad: float) -> dict[str, np.ndarray]:
        """Poses of cameras (n, 4, 4), the standing ones turned about the table's middle; those on a wrist move with it.

        Raises:
            BadInput: a camera stands where elevation has no direction.
        """
        turned = dict(poses)
        for name, camera in self.cameras.items():
            if camera.link is None:
                pose = raised(camera.pose, elevation_rad, what=f"{self.path}/scene.json: camera {name}")
                turned[name] = np.stack([pose] * len(poses[name]))
        return turned

    def job(self, folder: Path, clips: list[Clip], config: RenderConfig) -> Job:
        """Write what Blender's processes need into `folder`, but for what moves."""
        job = Job(
            folder=folder,
            texture=self.texture,
            settings={key: getattr(config, key) for key in SETTINGS},
            part_colors=self.part_colors,
            fy_over_height={name: camera.fy_px / camera.height for name, camera in self.cameras.items()},
            clips=clips,
        )
        job.write(self.arrays)
        return job


def _cameras(world: Scene, wanted: Sequence[str], scene: Path) -> dict[str, Camera]:
    known = {**world.cameras, **{f"{arm}_wrist": camera for arm, camera in world.wrist_cameras.items()}}
    if unknown := sorted(set(wanted) - set(known)):
        raise BadInput(f"{scene}/scene.json: no camera {', '.join(unknown)}; it has {', '.join(sorted(known))}")
    return {name: known[name] for name in wanted}


def _garment_and_table(mesh: Path, world: Scene) -> tuple[dict[str, np.ndarray], Path, np.ndarray]:
    """Meshes that only change place, the texture's file, and its sRGB colours (n, 3) at places of the garment."""
    rest_m, faces, uv, texture = read_textured(mesh, "rest_m")
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
    places = texture[y, x].reshape(-1, 3) / 255.0
    places = places[np.linspace(0, len(places) - 1, min(len(places), TEXTURE_PLACES)).astype(int)]
    return arrays, (mesh / "texture.png").resolve(), places
