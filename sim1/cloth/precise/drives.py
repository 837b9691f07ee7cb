"""Poses of drives at a simulation's steps, and how late an actuator follows them."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation, Slerp

from sim1.recording.streams import Track

BURST = 4.0  # times shorter than the median: steps of samples that came in a burst


def drive_pose(track: Track, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (T, 3) and rotation matrices (T, 3, 3) of a drive; constant outside its track.

    A cubic spline is as smooth as an arm moves. Through samples that came in a burst it would swing out beyond them all: of these the last
    was stamped when it was due, and the others are left out.
    """
    due = _due(track.time_s)
    at, position_m, rotation = track.time_s[due], track.position_m[due], track.rotation_wxyz[due]
    time = np.clip(time_s, *at[[0, -1]])
    turn = Slerp(at, Rotation.from_quat(rotation, scalar_first=True))(time).as_matrix()
    return CubicSpline(at, position_m)(time), turn


def _due(time_s: np.ndarray) -> np.ndarray:
    """Which samples (n,) no other follows in a burst; how long the first and the last step are says when one began to record, and ended."""
    due, step = np.ones(len(time_s), bool), np.diff(time_s)
    if len(step) > 2:
        due[1:-2] = step[1:-1] >= np.median(step[1:-1]) / BURST
    return due


def lagging(position_m: np.ndarray, turn: np.ndarray, lag_s: float, step_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions (T, 3) and rotation matrices (T, 3, 3) of a gripper that follows its command late, and stays rigid."""
    if lag_s <= 0.0:
        return position_m, turn
    quaternion = Rotation.from_matrix(turn).as_quat()
    flips = np.sign((quaternion[1:] * quaternion[:-1]).sum(1))
    quaternion[1:] *= np.cumprod(np.where(flips < 0.0, -1.0, 1.0))[:, None]  # one and the same turn, without jumps
    return late(position_m, lag_s, step_s), Rotation.from_quat(late(quaternion, lag_s, step_s)).as_matrix()


def late(path: np.ndarray, lag_s: float, step_s: float) -> np.ndarray:
    """The path (T, ...) behind a first-order lag, exact for commands that are linear between steps; the command rested before."""
    if lag_s <= 0.0:
        return path
    keep = np.exp(-step_s / lag_s)
    slope = np.diff(path, axis=0) / step_s
    drive = path[1:] - keep * path[:-1] - slope * lag_s * (1.0 - keep)
    first = path[0]
    follows, _ = lfilter([1.0], [1.0, -keep], drive, axis=0, zi=(keep * first)[None])
    return np.concatenate([first[None], follows])
