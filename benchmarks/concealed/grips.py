"""Which vertices of the laboratory's grid the grippers hold, and where those are for given drive poses."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.concealed.cloth import Grid
from benchmarks.concealed.motions.motion import Motion


@dataclass(frozen=True)
class Holds:
    """K held vertices. `places_m` (K, 3) are in the frames of their drives."""

    vertices: np.ndarray
    """(K,) flat indices on the grid."""
    drive: np.ndarray
    """(K,) which of the motion's blocks."""
    places_m: np.ndarray
    offsets_m: np.ndarray
    """(D, 3) middle of each hold in its drive's frame."""
    middles_m: np.ndarray
    """(D, 3) middle of each hold in the rest mesh."""


@dataclass(frozen=True)
class Poses:
    """Poses of the D drives at T times."""

    position_m: np.ndarray
    """(T, D, 3)"""
    rotation: np.ndarray
    """(T, D, 3, 3)"""


def hold(motion: Motion, grid: Grid, refine: int, offsets_m: np.ndarray) -> Holds:
    """All fine vertices within the held blocks; `offsets_m` (D, 3): how far the cloth is from each drive's own point."""
    vertices, drive, places, middles = [], [], [], []
    for number, block in enumerate(motion.blocks):
        rows = np.arange(block.rows[0] * refine, block.rows[1] * refine + 1)
        columns = np.arange(block.columns[0] * refine, block.columns[1] * refine + 1)
        row, column = (axis.ravel() for axis in np.meshgrid(rows, columns, indexing="ij"))
        flat = np.stack([column * grid.du_m, row * grid.dv_m, 0.0 * row], axis=1)
        middles.append(flat.mean(axis=0))
        vertices.append((row + 1) * grid.stride + column + 1)
        drive.append(np.full(len(row), number))
        places.append(flat - middles[-1] + offsets_m[number])
    return Holds(
        np.concatenate(vertices),
        np.concatenate(drive),
        np.concatenate(places),
        np.asarray(offsets_m),
        np.array(middles),
    )


def commanded(motion: Motion, holds: Holds, times_s: np.ndarray) -> Poses:
    """Poses that the robot is told to take."""
    shift, turn = motion.course(times_s)
    rotation = Rotation.from_rotvec(turn.reshape(-1, 3)).as_matrix().reshape(*turn.shape[:2], 3, 3)
    rotation = rotation @ motion.flat_rotation
    middle = holds.middles_m @ motion.flat_rotation.T + motion.flat_origin_m + shift
    return Poses(middle - np.einsum("tdij,dj->tdi", rotation, holds.offsets_m), rotation)


def flat_poses(motion: Motion, holds: Holds) -> Poses:
    """Poses (T = 1) at which the holds keep the sheet flat, as it lies in its rest mesh."""
    rotation = np.broadcast_to(motion.flat_rotation, (1, len(holds.offsets_m), 3, 3))
    middle = holds.middles_m @ motion.flat_rotation.T + motion.flat_origin_m
    return Poses(middle[None] - np.einsum("tdij,dj->tdi", rotation, holds.offsets_m), rotation)


def held_at(poses: Poses, holds: Holds) -> np.ndarray:
    """(T, K, 3) places of the held vertices in the world."""
    rotation = poses.rotation[:, holds.drive]
    return poses.position_m[:, holds.drive] + np.einsum("tkij,kj->tki", rotation, holds.places_m)


def between(start: Poses, end: Poses, turning: np.ndarray, shifting: np.ndarray) -> Poses:
    """From one pose (T = 1) to another, at shares (T,) of the turn and of the way."""
    turn = Rotation.from_matrix(np.swapaxes(start.rotation[0], -1, -2) @ end.rotation[0]).as_rotvec()
    partial = Rotation.from_rotvec((turning[:, None, None] * turn).reshape(-1, 3)).as_matrix()
    rotation = start.rotation[0] @ partial.reshape(len(turning), -1, 3, 3)
    position = start.position_m[0] + shifting[:, None, None] * (end.position_m[0] - start.position_m[0])
    return Poses(position, rotation)
