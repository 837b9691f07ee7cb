"""An interaction moved with its garment may leave the arms' reach; small changes of the tool's attitude bring it back.

The tool may keep its demonstrated yaw instead of turning with the garment, and lean forward more, away from the robot, whatever its
yaw. Fingers touch the table no lower for that: they are raised by as much as their lowest edge would sink.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.motion.commands import Arms
from sim1.motion.poses import ToolPath
from sim1.robot.gripper import below_m
from sim1.robot.kinematics import Unreachable

# (share of the garment's turn that the tool follows, additional lean in rad), the most faithful first
CHANGES = ((1.0, 0.0), (0.5, 0.0), (0.0, 0.0), (0.5, 0.15), (0.0, 0.15), (0.5, 0.3), (0.0, 0.3))


def reachable(
    path: ToolPath, placement: np.ndarray, arms: Arms, start_rad: np.ndarray
) -> tuple[ToolPath, tuple[float, float], np.ndarray]:
    """The path moved by `placement` with the first change that both arms can follow, that change, and joints (n, 2, 6).

    Args:
        path: as demonstrated.
        placement: (4, 4) motion on the table.
        arms: kinematics.
        start_rad: (2, 6) joints near the first frame.

    Raises:
        Unreachable: with every change; of the most faithful one.
    """
    problem: Unreachable | None = None
    for change in CHANGES:
        moved = changed(path, placement, *change)
        try:
            joints = arms.joints_for(moved, start_rad)
        except Unreachable as error:
            problem = problem or error
            continue
        return moved, change, joints
    assert problem is not None
    raise problem


def changed(path: ToolPath, placement: np.ndarray, turn_share: float, lean_rad: float) -> ToolPath:
    """Moved by `placement`; the tools follow a share of its turn and lean further along the world's x, which both arms point to."""
    turn = np.arctan2(placement[1, 0], placement[0, 0])
    rotation = Rotation.from_euler("z", turn_share * turn).as_matrix() @ path.rotation
    rotation = Rotation.from_euler("y", -lean_rad).as_matrix() @ rotation
    lift = below_m(rotation, path.openness) - below_m(path.rotation, path.openness)
    position = path.moved(placement).position_m
    position = position + lift[..., None] * np.array([0.0, 0.0, 1.0])
    return ToolPath(position_m=position, rotation=rotation, openness=path.openness)
