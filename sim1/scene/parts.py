"""Everything that stands in a scene, as coloured triangle meshes: what the USD file and the pictures are made of."""

from dataclasses import dataclass

import numpy as np

from sim1.episode import ARMS
from sim1.robot.kinematics import Arm
from sim1.robot.shapes import link_meshes
from sim1.scene.description import Scene

TABLE_RGB = np.array([0.62, 0.47, 0.34])
HOME_OPENING_M = 0.022  # fingers half open at home


@dataclass(frozen=True, kw_only=True)
class Part:
    """One rigid thing, placed in its parent's frame."""

    path: str  # below the scene's root, e.g. arms/left/link3
    pose: np.ndarray  # (4, 4) to world
    meshes: tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]  # vertices (v, 3), faces (f, 3), rgb (3,) or (f, 3)


def arm_parts(scene: Scene, arm: Arm, joints_rad: dict[str, np.ndarray] | None = None) -> list[Part]:
    """Links of both arms at the given joint angles (arm -> (6,)), at home where none are given."""
    angles = joints_rad or scene.home_rad
    parts = []
    for name in ARMS:
        poses = arm.link_poses(angles[name], HOME_OPENING_M)
        for link in arm.robot.links.values():
            meshes = tuple((v, f, np.array(rgba[:3])) for v, f, rgba in link_meshes(link))
            pose = scene.base_to_world[name] @ poses[link.name]
            parts.append(Part(path=f"arms/{name}/{link.name}", pose=pose, meshes=meshes))
    return parts


def solid(
    path: str, vertices_m: np.ndarray, faces: np.ndarray, rgb: np.ndarray, pose: np.ndarray | None = None
) -> Part:
    """A part of one mesh, in the world frame unless a `pose` is given."""
    return Part(path=path, pose=np.eye(4) if pose is None else pose, meshes=((vertices_m, faces, np.asarray(rgb)),))
