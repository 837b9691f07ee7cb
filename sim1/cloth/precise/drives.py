"""Poses of drives at a simulation's steps, and how late an actuator follows them."""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation, Slerp

from sim1.recording.streams import Track

UNEVEN = 4.0  # times shorter or longer than the median: steps of samples that came in bursts, or were lost


def drive_pose(track: Track, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (T, 3) and rotation matrices (T, 3, 3) of a drive; constant outside its track.

    A cubic spline is as smooth as an arm moves. Through samples that came in bursts it would swing out beyond them all, so that between
    those the path is monotone (Fritsch and Carlson 1980).
    """
    time = np.clip(time_s, *track.time_s[[0, -1]])
    turn = Slerp(track.time_s, Rotation.from_quat(track.rotation_wxyz, scalar_first=True))(time).as_matrix()
    between = CubicSpline if _even(np.diff(track.time_s)) else PchipInterpolator
    return between(track.time_s, track.position_m)(time), turn


def _even(step_s: np.ndarray) -> bool:
    """Whether samples follow each other about evenly; how much of a step the first and the last are depends on when one began to record."""
    inner = step_s[1:-1] if len(step_s) > 2 else step_s
    middle = float(np.median(inner))
    return middle / UNEVEN < inner.min() and inner.max() < middle * UNEVEN


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
