"""Synthetic demonstrations: two tools that travel, close on a sheet, lift it, open and go home."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.episode import RATE_HZ
from sim1.motion.commands import Arms
from sim1.motion.durations import DurationModel
from sim1.motion.model import MotionModel
from sim1.motion.pool import Segment
from sim1.motion.poses import ToolPath
from sim1.robot.kinematics import Arm

URDF = Path(__file__).parents[2] / "data" / "robot" / "robot.urdf"
HOME = np.array([[0.0, 0.6, 0.6, -0.9, 0.0, 0.0]] * 2)  # joints of both arms
BASES = np.stack([np.eye(4)] * 2)
BASES[:, :3, 3] = [[-0.36, 0.27, 0.15], [-0.36, -0.27, 0.15]]
FRAMES = {"reach": 40, "hold": 45, "back": 35}


def bell(count: int) -> np.ndarray:
    s = np.linspace(0, 1, count)
    return 10 * s**3 - 15 * s**4 + 6 * s**5


def curved(start: np.ndarray, end: np.ndarray, count: int, arch_m: float) -> np.ndarray:
    """Minimum jerk from start (2, 3) to end with an arch upwards: what a residual has to learn."""
    path = start + bell(count)[:, None, None] * (end - start)
    path[..., 2] += arch_m * np.sin(np.pi * np.linspace(0, 1, count))[:, None] ** 2
    return path


def tool_path(position_m: np.ndarray, openness: np.ndarray, turn_rad: float = 0.0) -> ToolPath:
    angle = np.linspace(0, turn_rad, len(position_m))
    down = Rotation.from_euler("y", 90, degrees=True)
    one = (Rotation.from_euler("z", angle[:, None]) * down).as_matrix()
    return ToolPath(position_m=position_m, rotation=np.repeat(one[:, None], 2, axis=1), openness=openness)


def closing(count: int) -> np.ndarray:
    """Openness (count, 2) of grippers that close, hold and open again."""
    one = np.interp(np.arange(count), [3, 9, count - 10, count - 4], [1.0, 0.1, 0.1, 1.0])
    return np.stack([one, one], axis=1)


def a_demo(name: str, rng: np.random.Generator, first: int, success: bool = True) -> list[Segment]:
    home = np.array([[-0.2, 0.25, 0.25], [-0.2, -0.25, 0.25]]) + rng.normal(0, 0.005, (2, 3))
    grasp = np.array([[0.1, 0.15, 0.01], [0.1, -0.15, 0.01]]) + rng.normal(0, 0.01, (2, 3))
    drop = grasp + np.array([-0.15, 0, 0.02])
    arch = 0.05 + 0.01 * rng.standard_normal()
    parts = [
        ("moving", tool_path(curved(home, grasp, FRAMES["reach"], arch), np.ones((FRAMES["reach"], 2)), 0.3)),
        ("interacting", tool_path(curved(grasp, drop, FRAMES["hold"], 0.08), closing(FRAMES["hold"]), 0.3)),
        ("moving", tool_path(curved(drop, home, FRAMES["back"], arch), np.ones((FRAMES["back"], 2)), 0.3)),
    ]
    segments, frame, orders = [], 0, {"moving": 0, "interacting": 0}
    for kind, path in parts:
        grasps = (0, 1) if kind == "interacting" else (-1, -1)
        joints = np.zeros((len(path), 2, 6))
        segments.append(
            Segment(
                segment=first + len(segments), demo=name, kind=kind, order=orders[kind], start_frame=frame,
                end_frame=frame + len(path), grasp_left=grasps[0], grasp_right=grasps[1], success=success,
                garment="sheet", joints_rad=joints, path=path,
            )
        )  # fmt: skip
        orders[kind] += 1
        frame += len(path)
    return segments


def two_arms() -> Arms:
    return Arms(arm=Arm.from_urdf(URDF), bases_to_world=BASES)


def a_model(method="minimum_jerk", rest_s=1.0) -> MotionModel:
    """A model that needs no training."""
    durations = DurationModel(rest_s=rest_s, s_per_m=1.0, s_per_rad=0.3, log_std=0.1)
    return MotionModel(
        method=method, durations=durations, network=None, scale=np.ones(20), width=64, layer_count=3, token_count=32,
        shape_count=20, sampling_steps=16,
    )  # fmt: skip


def speed_shares(command_joints_rad: np.ndarray, arms: Arms) -> np.ndarray:
    """Speeds of commands (n, 2, 6), that of the step from home first, each over its own joint's limit: (n, 2, 6)."""
    steps_rad = np.diff(np.concatenate([HOME[None], command_joints_rad]), axis=0)
    return np.abs(steps_rad) * RATE_HZ / arms.arm.velocity_limit_rad_s


def reaching_demos(arms: Arms, count: int) -> list[Segment]:
    """Demonstrations within reach: out and down on an arch, a pull by 5 cm, back home; no two are alike."""
    rng = np.random.default_rng(11)
    home = arms.tool_path(HOME[None], np.ones((1, 2)))
    segments: list[Segment] = []
    for index in range(count):
        grasp = home.position_m[0] + np.array([0.06, 0.0, -0.08]) + rng.normal(0, 0.004, (2, 3))
        drop, arch = grasp + np.array([-0.05, 0.0, 0.02]), 0.03 + 0.004 * rng.standard_normal()
        ways = [(home.position_m[0], grasp, arch), (grasp, drop, 0.01), (drop, home.position_m[0], arch)]
        for part, (start, end, height) in zip(a_demo(f"{index:04d}", rng, 3 * index), ways, strict=True):
            frames = len(part.path)
            path = ToolPath(
                position_m=curved(start, end, frames, height),
                rotation=np.repeat(home.rotation, frames, axis=0),
                openness=part.path.openness,
            )
            joints = arms.joints_for(path, HOME)
            segments.append(part.__class__(**{**part.__dict__, "path": path, "joints_rad": joints}))
    return segments
