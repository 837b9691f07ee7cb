"""A towel on a table between two arms, small enough to be rendered in seconds."""

import shutil
from pathlib import Path

import numpy as np
import trimesh
from PIL import Image

from sim1.episode import ARMS, RATE_HZ, Episode, write_episode
from sim1.scene.description import Camera, Scene, write_scene

DATA = Path(__file__).parents[2] / "data"
URDF = DATA / "robot" / "robot.urdf"
LOOKS = DATA / "appearance"
GRID = 12


def looking_at_origin(eye: tuple[float, float, float]) -> np.ndarray:
    z = np.array(eye) / np.linalg.norm(eye)
    x = np.cross([0.0, 0.0, 1.0], z)
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.c_[x, np.cross(z, x), z], eye
    return pose


def towel() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (v, 3), faces (f, 3) and uv (f, 3, 2) of a flat towel of 0.5 m by 0.4 m."""
    grid = np.stack(np.meshgrid(np.linspace(0, 1, GRID), np.linspace(0, 1, GRID), indexing="ij"), -1).reshape(-1, 2)
    index = np.arange(GRID * GRID).reshape(GRID, GRID)
    a, b, c, d = (
        index[i, j].ravel()
        for i, j in np.s_[
            (slice(-1), slice(-1)),
            (slice(1, None), slice(-1)),
            (slice(1, None), slice(1, None)),
            (slice(-1), slice(1, None)),
        ]
    )
    faces = np.r_[np.c_[a, b, c], np.c_[a, c, d]].astype(np.int32)
    vertices = np.c_[(grid - 0.5) * [0.5, 0.4], np.zeros(len(grid))]
    return vertices, faces, grid[faces]


def episode(frame_count: int) -> Episode:
    """A towel whose far edge rises while the arms turn."""
    vertices, _, _ = towel()
    phase = np.linspace(0.0, 1.0, frame_count)
    garment = np.repeat(vertices[None], frame_count, axis=0)
    garment[..., 2] = 0.004 + 0.1 * phase[:, None] * np.clip(vertices[:, 0], 0.0, None) / 0.25
    joints = np.zeros((frame_count, 2, 6))
    joints[..., 1], joints[..., 2] = 1.2, 1.2
    joints[..., 0] = 0.4 * phase[:, None]
    openness = np.repeat(phase[:, None], 2, axis=1)
    return Episode(
        time_s=np.arange(frame_count) / RATE_HZ,
        joints_rad=joints,
        openness=openness,
        command_joints_rad=joints + 0.01,
        command_openness=openness,
        garment_m=garment.astype(np.float32),
        about={"garment": "towel", "task_text": "fold the towel", "seed": 3, "sources": ["0000"], "success": True},
    )


def write_inputs(folder: Path, frame_count: int = 7) -> dict[str, dict[str, Path]]:
    """Artifacts that the stage needs, of one garment, and a copy of the shipped looks."""
    mesh, scene, trajectories = (folder / name for name in ("mesh", "scene", "trajectories"))
    for path in (mesh, scene, trajectories):
        path.mkdir()
    vertices, faces, uv = towel()
    np.savez(
        mesh / "mesh.npz",
        vertices_m=vertices.astype(np.float32),
        faces=faces,
        uv=uv.astype(np.float32),
        rest_m=vertices.astype(np.float32),
    )
    Image.new("RGB", (8, 8), (200, 60, 40)).save(mesh / "texture.png")
    shutil.copy(URDF, scene / "robot.urdf")
    table = trimesh.creation.box((0.8, 1.2, 0.03))
    table.apply_translation((0.0, 0.0, -0.015))
    table.export(scene / "table.obj")
    bases = {}
    for arm, y in zip(ARMS, (0.3, -0.3)):
        bases[arm] = np.eye(4)
        bases[arm][:3, 3] = (-0.35, y, 0.0)
    wrist = looking_at_origin((-0.15, 0.0, 0.25))  # above the hand, looking at the finger tips' side
    write_scene(
        scene,
        Scene(
            table_mesh=scene / "table.obj",
            table_size_m=np.array([0.8, 1.2, 0.03]),
            table_top_m=0.0,
            urdf=scene / "robot.urdf",
            base_to_world=bases,
            garment_place=np.eye(4),
            cameras={"head": Camera(width=640, height=480, fy_px=420.0, pose=looking_at_origin((-0.45, 0.0, 0.8)))},
            home_rad={arm: np.full(6, 0.5) for arm in ARMS},
            wrist_cameras={arm: Camera(width=640, height=480, fy_px=420.0, pose=wrist, link="link6") for arm in ARMS},
        ),
    )
    write_episode(trajectories / "episodes" / "0000", episode(frame_count))
    shutil.copytree(LOOKS, folder / "appearance")
    return {
        "garment_mesh": {"towel": mesh},
        "scene": {"towel": scene},
        "valid_trajectories": {"towel": trajectories},
        "appearance": {"towel": folder / "appearance"},
    }
