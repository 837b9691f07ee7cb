"""Closed-form postures with the tool in the vertical plane of the arm (joints 5 and 6 at zero), for reach studies."""

from dataclasses import dataclass

import numpy as np

from sim1.robot.kinematics import Arm


@dataclass(frozen=True, kw_only=True)
class PlanarArm:
    """An X5-shaped arm seen from its side: shoulder, upper arm, forearm, tool. Lengths in metres."""

    shoulder: np.ndarray  # (2,) forward of joint 1's axis, above the base
    upper_arm: float
    forearm: float
    forearm_rise_rad: float  # of the wrist above the forearm frame's x axis
    tool: float  # from the wrist's pitch axis
    side: float  # tool's offset to the left of the plane
    lower_rad: np.ndarray  # (6,)
    upper_rad: np.ndarray  # (6,)

    @classmethod
    def of(cls, arm: Arm) -> "PlanarArm":
        """Read the lengths off the arm's frames at zero, where the upper arm points along -x."""
        poses = arm.link_poses(np.zeros(6))
        shoulder, elbow, wrist, tool = (poses[name][:3, 3] for name in ("link2", "link3", "link4", "tool"))
        lever = wrist - elbow
        return cls(
            shoulder=shoulder[[0, 2]],
            upper_arm=float(np.linalg.norm(elbow - shoulder)),
            forearm=float(np.linalg.norm(lever)),
            forearm_rise_rad=float(np.arctan2(lever[2], lever[0])),
            tool=float(tool[0] - wrist[0]),
            side=float(tool[1]),
            lower_rad=arm.lower_rad,
            upper_rad=arm.upper_rad,
        )

    @property
    def stretched_m(self) -> float:
        """Length of the straight arm from shoulder to tool."""
        return self.upper_arm + self.forearm + self.tool

    def postures(self, points_m: np.ndarray, tilt_rad: float) -> np.ndarray:
        """Joint angles (n, 6) that put the tool at `points_m` (n, 3; base frame), NaN where it cannot be.

        The tool points down, leaning outward by `tilt_rad`; the elbow is above the line from shoulder to wrist.
        """
        x, y, z = points_m.T
        distance = np.hypot(x, y)
        turn = np.arctan2(y, x) - np.arcsin(np.clip(self.side / np.maximum(distance, 1e-9), -1, 1))
        ahead = np.sqrt(np.maximum(distance**2 - self.side**2, 0))
        direction = np.array([np.sin(tilt_rad), -np.cos(tilt_rad)])
        wrist = np.stack([ahead, z], axis=-1) - self.tool * direction - self.shoulder
        span = np.linalg.norm(wrist, axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            inner = np.arccos((self.upper_arm**2 + span**2 - self.forearm**2) / (2 * self.upper_arm * span))
        raised = np.arctan2(wrist[:, 1], wrist[:, 0]) + inner
        elbow = self.upper_arm * np.stack([np.cos(raised), np.sin(raised)], axis=-1)
        forearm = wrist - elbow
        pitch = np.arctan2(forearm[:, 1], forearm[:, 0]) - self.forearm_rise_rad
        q2 = np.pi - raised
        q3 = _wrap(pitch + q2 - np.pi / 2) + np.pi / 2  # the range of joint 3 is 0 to pi
        q4 = _wrap(tilt_rad - np.pi / 2 - pitch)
        zero = np.zeros_like(q2)
        q = np.stack([_wrap(turn), q2, q3, q4, zero, zero], axis=-1)
        inside = ((q >= self.lower_rad) & (q <= self.upper_rad)).all(axis=-1)
        return np.where(inside[:, None], q, np.nan)


def _wrap(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2 * np.pi) - np.pi
