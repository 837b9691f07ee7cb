"""Where the garment lies at the start: a rigid motion from its mesh onto the table."""

import numpy as np
import trimesh

from sim1.stage import BadInput

FLAT_SHARE = 0.3  # thinner than this share of its other extents counts as scanned lying, like a towel
NEARLY_SQUARE = 1.05  # longer by less than this factor is not longer


def lying_pose(vertices_m: np.ndarray, top_m: float, gap_m: float) -> np.ndarray:
    """Motion (4, 4) that lays a garment mesh (v, 3) on the middle of the table, `gap_m` above its top, front side up.

    The mesh stands in the scan's frame: front x, left y, up z. A garment scanned upright, on a mannequin, falls on its back:
    up (the collar) goes to -x of the world, the front to +z, its left stays at +y. Its exact turn about the upright axis
    comes from the mesh: the horizontal principal axis of greater spread runs from one side of a garment to the other.
    A garment scanned lying keeps its upper side; the longer side of its smallest rectangle goes along y, the direction in
    which the two arms stand apart.

    Raises:
        BadInput: an upright garment that is wider from front to back than from side to side.
    """
    extents = np.ptp(vertices_m, axis=0)
    if extents[2] < FLAT_SHARE * extents[:2].min():
        turn = _turn_of_flat(vertices_m)
    else:
        turn = _turn_of_upright(vertices_m)
    turned = vertices_m @ turn.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = [-(low[0] + high[0]) / 2, -(low[1] + high[1]) / 2, top_m + gap_m - low[2]]
    return pose


def _turn_of_flat(vertices_m: np.ndarray) -> np.ndarray:
    to_origin, sides = trimesh.bounds.oriented_bounds_2D(vertices_m[:, :2])
    first, second = to_origin[:2, :2]  # directions of the two sides
    if max(sides) < NEARLY_SQUARE * min(sides):
        along = first if abs(first[1]) > abs(second[1]) else second  # as it was scanned: no side is the longer one
    else:
        along = first if sides[0] > sides[1] else second
    if along[1] < 0 or (along[1] == 0 and along[0] > 0):
        along = -along  # the smaller of the two possible turns
    forward = np.array([along[1], -along[0]])
    return np.array([[*forward, 0], [*along, 0], [0, 0, 1]])


def _turn_of_upright(vertices_m: np.ndarray) -> np.ndarray:
    spread, axes = np.linalg.eigh(np.cov(vertices_m[:, :2].T))
    left = axes[:, int(np.argmax(spread))]
    if abs(left[1]) < abs(left[0]):
        raise BadInput(
            "garment mesh: wider from front (x) to back than from left (y) to right; set frame.front in the garment file to"
            " the axis of the scan that the garment's front faces"
        )
    left = left * np.sign(left[1])
    front = np.array([left[1], -left[0]])
    return np.array([[0, 0, -1], [*left, 0], [*front, 0]])
