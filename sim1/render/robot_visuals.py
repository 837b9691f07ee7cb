"""What the robot looks like and where its parts are: the URDF's visual shapes of both arms as meshes that move."""

from dataclasses import dataclass

import numpy as np
import trimesh

from sim1.episode import ARMS
from sim1.robot.gripper import travel_from_openness
from sim1.robot.kinematics import Arm
from sim1.robot.urdf import Shape

SECTIONS = 24  # faces around a cylinder: smooth enough for a picture


@dataclass(frozen=True, kw_only=True)
class Part:
    """One visual shape of one arm."""

    arm: int  # index in `ARMS`
    link: str
    vertices_m: np.ndarray  # (v, 3) in the link's frame
    faces: np.ndarray  # (f, 3)
    color: tuple[float, float, float]  # sRGB


def robot_parts(arm: Arm) -> list[Part]:
    """All visual shapes of both arms, in the URDF's order."""
    return [
        _part(index, name, shape)
        for index in range(len(ARMS))
        for name, link in arm.robot.links.items()
        for shape in link.visuals
    ]


def link_motion(
    arm: Arm, base_to_world: dict[str, np.ndarray], *, joints_rad: np.ndarray, openness: np.ndarray
) -> list[list[dict[str, np.ndarray]]]:
    """World frame (4, 4) of every link: frame -> arm -> link name -> pose.

    Args:
        arm: the kinematics that both arms share.
        base_to_world: arm name -> (4, 4).
        joints_rad: (n, 2, 6).
        openness: (n, 2).
    """
    motion = []
    for angles, opened in zip(joints_rad, openness, strict=True):
        frame = []
        for index, name in enumerate(ARMS):
            poses = arm.link_poses(angles[index], travel_m=float(travel_from_openness(opened[index])))
            frame.append({link: base_to_world[name] @ pose for link, pose in poses.items()})
        motion.append(frame)
    return motion


def part_poses(parts: list[Part], motion: list[list[dict[str, np.ndarray]]]) -> np.ndarray:
    """World frames of the parts, (n, p, 4, 4)."""
    return np.array([[frame[part.arm][part.link] for part in parts] for frame in motion]).reshape(
        len(motion), len(parts), 4, 4
    )


def _part(arm: int, link: str, shape: Shape) -> Part:
    match shape.kind:
        case "box":
            mesh = trimesh.creation.box(shape.size_m)
        case "cylinder":
            mesh = trimesh.creation.cylinder(*shape.size_m, sections=SECTIONS)
        case "sphere":
            mesh = trimesh.creation.icosphere(subdivisions=2, radius=shape.size_m[0])
        case kind:
            raise ValueError(f"shape {kind!r} of link {link!r} cannot be drawn")
    mesh.apply_transform(shape.origin)
    return Part(
        arm=arm, link=link, vertices_m=np.asarray(mesh.vertices), faces=np.asarray(mesh.faces), color=shape.rgba[:3]
    )
