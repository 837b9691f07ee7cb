"""Joint commands for a tool path: inverse kinematics frame by frame, with joint limits and speeds checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sim1.episode import ARMS, RATE_HZ
from sim1.motion.poses import ToolPath, from_joints

if TYPE_CHECKING:
    from sim1.robot.kinematics import Arm
    from sim1.scene.description import Scene


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """How far a tool may pass beside a pose where a joint is at its limit."""

    position_m: float
    rotation_rad: float


HANDLING = Tolerance(position_m=1e-3, rotation_rad=0.02)  # what a real arm is off anyway
FREE = Tolerance(
    position_m=0.02, rotation_rad=0.25
)  # with open fingers above the cloth; what comes of it is simulated and judged


@dataclass(frozen=True, kw_only=True)
class Arms:
    """Both arms of the cell, alike, at their places."""

    arm: Arm
    bases_to_world: np.ndarray  # (2, 4, 4)

    @classmethod
    def of_scene(cls, scene: Scene) -> Arms:
        """The arms that stand in `scene`."""
        from sim1.robot.kinematics import Arm

        return cls(arm=Arm.from_urdf(scene.urdf), bases_to_world=np.stack([scene.base_to_world[name] for name in ARMS]))

    def tool_path(self, joints_rad: np.ndarray, openness: np.ndarray) -> ToolPath:
        """Where the tools are for joints (n, 2, 6)."""
        return from_joints(joints_rad, openness, self.arm, self.bases_to_world)

    def joints_for(self, path: ToolPath, start_rad: np.ndarray, tolerance: Tolerance = HANDLING) -> np.ndarray:
        """Joint angles (n, 2, 6) that follow `path`, each frame starting from the one before.

        Args:
            path: n frames.
            start_rad: (2, 6) angles before the first frame.
            tolerance: where joints are within their limits, poses are met to far less.

        Raises:
            Unreachable: a pose is out of reach or needs joints beyond their limits.
        """
        inverse_bases = np.linalg.inv(self.bases_to_world)
        targets = inverse_bases @ path.matrices()
        joints = np.empty((len(path), 2, start_rad.shape[-1]))
        for side in range(2):
            angles = start_rad[side]
            for frame in range(len(path)):
                # No restarts: another posture for the same pose would be a jump.
                angles = self.arm.inverse(
                    targets[frame, side],
                    angles,
                    restart_count=0,
                    position_tolerance_m=tolerance.position_m,
                    rotation_tolerance_rad=tolerance.rotation_rad,
                )
                joints[frame, side] = angles
        return joints

    def speed_share(self, joints_rad: np.ndarray, start_rad: np.ndarray) -> float:
        """Fastest joint speed of (n, 2, 6), the step from `start_rad` (2, 6) included, over its limit."""
        steps = np.diff(np.concatenate([start_rad[None], joints_rad]), axis=0)
        return float((np.abs(steps) * RATE_HZ / self.arm.velocity_limit_rad_s).max())
