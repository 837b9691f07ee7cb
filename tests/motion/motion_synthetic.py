"""Synthetic demonstrations: two tools that travel, close on a sheet, lift it, open and go home."""

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.motion.pool import Segment
from sim1.motion.poses import ToolPath

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
