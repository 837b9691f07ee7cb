"""Where an arm's tool is for given joint angles, and which angles put it where."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.robot.urdf import Joint, Robot, read_urdf, rotation
from sim1.stage import BadInput, random_stream

BASE, TOOL = "base_link", "tool"


class Unreachable(ValueError):
    """No joint angles within the limits put the tool there; the best attempt's errors say how far off it is."""

    def __init__(self, position_error_m: float, rotation_error_rad: float) -> None:
        self.position_error_m = position_error_m
        self.rotation_error_rad = rotation_error_rad
        super().__init__(
            f"tool pose out of reach: the nearest found is {1000 * position_error_m:.1f} mm and "
            f"{np.degrees(rotation_error_rad):.1f} degrees away"
        )


@dataclass(frozen=True, kw_only=True)
class Arm:
    """A serial chain of revolute joints from `BASE` to `TOOL`, with the gripper's fingers beside it."""

    robot: Robot

    @classmethod
    def from_urdf(cls, path: Path) -> "Arm":
        """Read the arm.

        Raises:
            BadInput: the file is damaged, or the chain from base to tool does not have six revolute joints.
        """
        arm = cls(robot=read_urdf(Path(path)))
        if len(arm.joints) != 6 or any(joint.kind == "prismatic" for joint in arm.chain):
            raise BadInput(
                f"{path}: {len(arm.joints)} moving joints from {BASE!r} to {TOOL!r}, expected six revolute ones"
            )
        return arm

    @cached_property
    def chain(self) -> tuple[Joint, ...]:
        """Joints from base to tool, fixed ones included."""
        return self.robot.path(BASE, TOOL)

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """The six joints that move, from the base outward."""
        return tuple(joint for joint in self.chain if joint.kind != "fixed")

    @cached_property
    def lower_rad(self) -> np.ndarray:
        """Lower joint limits (6,)."""
        return np.array([joint.lower for joint in self.joints])

    @cached_property
    def upper_rad(self) -> np.ndarray:
        """Upper joint limits (6,)."""
        return np.array([joint.upper for joint in self.joints])

    @cached_property
    def velocity_limit_rad_s(self) -> np.ndarray:
        """Joint speed limits (6,)."""
        return np.array([joint.velocity for joint in self.joints])

    def forward(self, q: np.ndarray) -> np.ndarray:
        """Tool frame in the base frame, (..., 4, 4), for joint angles `q` (..., 6) in rad."""
        return self._frames(np.asarray(q, float))[-1]

    def link_poses(self, q: np.ndarray, travel_m: float = 0.0) -> dict[str, np.ndarray]:
        """Frame (4, 4) of every link in the base frame, fingers opened by `travel_m` each, for `q` (6,) in rad."""
        q = np.asarray(q, float)
        angles = {joint.name: float(value) for joint, value in zip(self.joints, q, strict=True)}
        poses = {BASE: np.eye(4)}
        waiting = list(self.robot.joints.values())
        while waiting:
            joint = next(joint for joint in waiting if joint.parent in poses)
            waiting.remove(joint)
            value = angles.get(joint.name, travel_m if joint.kind == "prismatic" else 0.0)
            poses[joint.child] = poses[joint.parent] @ _joint_frame(joint, np.asarray(value))
        return poses

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Velocity of the tool (rows: linear m/s, then angular rad/s, base frame) by joint speed, (6, 6), at `q` (6,)."""
        frames = self._frames(np.asarray(q, float))
        moving = [(frame, joint.axis) for frame, joint in zip(frames, self.chain, strict=True) if joint.kind != "fixed"]
        axes = np.stack([frame[:3, :3] @ axis for frame, axis in moving])
        arms = frames[-1][:3, 3] - np.stack([frame[:3, 3] for frame, _ in moving])
        return np.concatenate([np.cross(axes, arms), axes], axis=1).T

    def inverse(
        self,
        target: np.ndarray,
        q_start: np.ndarray,
        *,
        position_tolerance_m: float = 1e-4,
        rotation_tolerance_rad: float = 1e-3,
        restart_count: int = 20,
    ) -> np.ndarray:
        """Joint angles (6,) within the limits that put the tool at `target` (4, 4), found by damped least squares.

        Starts from `q_start` (6,), so that nearby targets give nearby angles; restarts from fixed random postures only
        when that fails.

        Raises:
            Unreachable: no start led there.
        """
        stream = random_stream(0, "inverse kinematics")
        best_errors, best_cost = (np.inf, np.inf), np.inf
        start = np.clip(np.asarray(q_start, float), self.lower_rad, self.upper_rad)
        for _ in range(restart_count + 1):
            q, position_error, rotation_error = self._descend(target, start)
            if position_error <= position_tolerance_m and rotation_error <= rotation_tolerance_rad:
                return q
            cost = position_error + 0.1 * rotation_error
            if cost < best_cost:
                best_errors, best_cost = (position_error, rotation_error), cost
            start = stream.uniform(self.lower_rad, self.upper_rad)
        raise Unreachable(*best_errors)

    def _frames(self, q: np.ndarray) -> list[np.ndarray]:
        """Frame (..., 4, 4) behind each joint of the chain."""
        frame = np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))
        frames, index = [], 0
        for joint in self.chain:
            if joint.kind == "fixed":
                frame = frame @ joint.origin
            else:
                frame = frame @ _joint_frame(joint, q[..., index])
                index += 1
            frames.append(frame)
        return frames

    def _descend(self, target: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, float, float]:
        """Levenberg-Marquardt with joints clamped to their limits; returns angles and both errors."""
        weight = np.array([1, 1, 1, 0.1, 0.1, 0.1])  # 1 rad counts like 0.1 m, about the tool's length
        damping = 1e-3
        error = self._error(target, q)
        for _ in range(80):
            if np.linalg.norm(error[:3]) < 1e-7 and np.linalg.norm(error[3:]) < 1e-6:
                break
            jacobian = weight[:, None] * self.jacobian(q)
            weighted = weight * error
            # Joints that the step would press against their stop take no part in it.
            slope = jacobian.T @ weighted
            free = ~(((q <= self.lower_rad) & (slope < 0)) | ((q >= self.upper_rad) & (slope > 0)))
            step = np.zeros(6)
            j = jacobian[:, free]
            step[free] = np.linalg.solve(j.T @ j + damping**2 * np.eye(j.shape[1]), slope[free])
            step *= min(1.0, 0.6 / max(np.abs(step).max(), 1e-12))
            trial = np.clip(q + step, self.lower_rad, self.upper_rad)
            trial_error = self._error(target, trial)
            if np.linalg.norm(weight * trial_error) < np.linalg.norm(weighted):
                q, error, damping = trial, trial_error, max(damping * 0.4, 1e-5)
            else:
                damping *= 4
                if damping > 1e2:
                    break
        return q, float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))

    def _error(self, target: np.ndarray, q: np.ndarray) -> np.ndarray:
        """From the tool to the target: metres, then rotation vector in rad, base frame, (6,)."""
        tool = self.forward(q)
        turn = Rotation.from_matrix(target[:3, :3] @ tool[:3, :3].T).as_rotvec()
        return np.concatenate([target[:3, 3] - tool[:3, 3], turn])


def _joint_frame(joint: Joint, value: np.ndarray) -> np.ndarray:
    """Frame of a joint's child in its parent, (..., 4, 4), at joint values (...) in rad or m."""
    motion = np.broadcast_to(np.eye(4), (*value.shape, 4, 4)).copy()
    if joint.kind == "prismatic":
        motion[..., :3, 3] = value[..., None] * joint.axis
    elif joint.kind == "revolute":
        motion[..., :3, :3] = rotation(joint.axis, value)
    return joint.origin @ motion
