"""Tool poses of both arms over time, and the 20 numbers a frame that the motion model sees of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sim1.robot.kinematics import Arm

TOKEN_SIZE = 20  # two arms of position (3), 6-D rotation (6), openness (1)


@dataclass(frozen=True, kw_only=True)
class ToolPath:
    """Both tools over n frames, world frame."""

    position_m: np.ndarray  # (n, 2, 3)
    rotation: np.ndarray  # (n, 2, 3, 3)
    openness: np.ndarray  # (n, 2) in [0, 1]

    def __len__(self) -> int:
        return len(self.position_m)

    def __getitem__(self, frames: slice | np.ndarray) -> ToolPath:
        return ToolPath(
            position_m=self.position_m[frames], rotation=self.rotation[frames], openness=self.openness[frames]
        )

    def moved(self, transform: np.ndarray) -> ToolPath:
        """Rigidly moved by a (4, 4) transform of the world."""
        return ToolPath(
            position_m=self.position_m @ transform[:3, :3].T + transform[:3, 3],
            rotation=transform[:3, :3] @ self.rotation,
            openness=self.openness,
        )

    def mirrored(self) -> ToolPath:
        """Left and right exchanged by reflection in the plane y = 0.

        The gripper's own mirror image in its x-z plane is itself, so the reflected frame M R M is a rotation again.
        """
        mirror = np.array([1.0, -1.0, 1.0])
        return ToolPath(
            position_m=(self.position_m * mirror)[:, ::-1],
            rotation=(self.rotation * mirror[:, None] * mirror)[:, ::-1],
            openness=self.openness[:, ::-1],
        )

    def matrices(self) -> np.ndarray:
        """(n, 2, 4, 4) tool to world."""
        result = np.zeros((len(self), 2, 4, 4))
        result[..., :3, :3], result[..., :3, 3], result[..., 3, 3] = self.rotation, self.position_m, 1.0
        return result


def from_matrices(tool_to_world: np.ndarray, openness: np.ndarray) -> ToolPath:
    """ToolPath of (n, 2, 4, 4) poses and (n, 2) openness."""
    return ToolPath(
        position_m=tool_to_world[..., :3, 3], rotation=tool_to_world[..., :3, :3], openness=np.asarray(openness)
    )


def from_joints(joints_rad: np.ndarray, openness: np.ndarray, arm: Arm, bases_to_world: np.ndarray) -> ToolPath:
    """ToolPath of joints (n, 2, 6), arms at bases (2, 4, 4)."""
    return from_matrices(bases_to_world @ arm.forward(joints_rad), openness)


def joined(*paths: ToolPath) -> ToolPath:
    """One path after the other."""
    return ToolPath(
        position_m=np.concatenate([path.position_m for path in paths]),
        rotation=np.concatenate([path.rotation for path in paths]),
        openness=np.concatenate([path.openness for path in paths]),
    )


def rotation_to_6d(rotation: np.ndarray) -> np.ndarray:
    """First two columns of (..., 3, 3), one after the other: (..., 6). Source: Zhou et al. 2019, section 4."""
    return np.concatenate([rotation[..., :, 0], rotation[..., :, 1]], axis=-1)


def rotation_from_6d(six: np.ndarray) -> np.ndarray:
    """Nearest rotation by Gram-Schmidt of (..., 6), two vectors that must not be parallel: (..., 3, 3)."""
    first = six[..., :3] / np.linalg.norm(six[..., :3], axis=-1, keepdims=True)
    second = six[..., 3:] - (first * six[..., 3:]).sum(axis=-1, keepdims=True) * first
    second = second / np.linalg.norm(second, axis=-1, keepdims=True)
    return np.stack([first, second, np.cross(first, second)], axis=-1)


def to_tokens(path: ToolPath) -> np.ndarray:
    """(n, 20): position, 6-D rotation, openness of the left arm, then of the right."""
    parts = [path.position_m, rotation_to_6d(path.rotation), path.openness[..., None]]
    return np.concatenate(parts, axis=-1).reshape(len(path), TOKEN_SIZE)


def from_tokens(tokens: np.ndarray) -> ToolPath:
    """Inverse of `to_tokens`; rotations are made orthonormal, openness is kept inside [0, 1]."""
    arms = tokens.reshape(len(tokens), 2, TOKEN_SIZE // 2)
    return ToolPath(
        position_m=arms[..., :3], rotation=rotation_from_6d(arms[..., 3:9]), openness=np.clip(arms[..., 9], 0, 1)
    )


def turned_tokens(tokens: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Tokens (n, 20), or differences of them, seen in a frame that `rotation` (3, 3) takes back: vectors are turned."""
    arms = tokens.reshape(len(tokens), 2, TOKEN_SIZE // 2).copy()
    vectors = arms[..., :9].reshape(len(tokens), 2, 3, 3)  # position and two columns of the rotation
    arms[..., :9] = (vectors @ rotation.T).reshape(len(tokens), 2, 9)
    return arms.reshape(len(tokens), TOKEN_SIZE)
