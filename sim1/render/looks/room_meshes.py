"""Where a room's floor, walls and furniture stand about the table, as meshes in the world frame."""

from dataclasses import dataclass

import numpy as np

from sim1.render.appearance import Room
from sim1.render.looks.furniture import FURNITURE, Part, joined, trestle
from sim1.render.looks.turns import about_z

CLEAR_M = 0.1  # from the table's corner to the nearest piece
FLOOR_BELOW_M = 0.7  # under a table top that has no legs of its own
PLATE_M = 0.3  # a table mesh thinner than that is a top without legs
WALL_M = 2.5  # height of a wall


@dataclass(frozen=True, kw_only=True)
class RoomMeshes:
    """World frame, metres."""

    floor: np.ndarray  # (4, 3) corners, counter-clockwise from above
    floor_flat_m: (
        np.ndarray
    )  # (4, 2) the same about the floor's middle, along the walls: planks and tiles turn with the room
    walls: np.ndarray  # (4, 4, 3) corners of each, facing inwards
    furniture: tuple[Part, ...]  # at most one per colour


def room_meshes(room: Room, table_m: np.ndarray) -> RoomMeshes:
    """Place the room about the table.

    Args:
        room: as drawn.
        table_m: (v, 3) vertices of the table.
    """
    low, high = table_m.min(axis=0), table_m.max(axis=0)
    is_plate = high[2] - low[2] < PLATE_M
    ground = low[2] - (FLOOR_BELOW_M if is_plate else 0.0)
    clear = np.hypot(*np.maximum(np.abs(low[:2]), np.abs(high[:2]))) + CLEAR_M
    parts = []
    for piece in room.furniture:
        out = clear + piece.gap_m
        parts += [_moved(part, piece.bearing_rad, out) for part in FURNITURE.make(piece.shape)]
    reach = np.max([np.abs(part.vertices_m[:, :2]).max(axis=0) for part in parts] or [[0.0, 0.0]], axis=0)
    half = np.maximum(np.array(room.size_m) / 2, reach + 0.02)  # walls stand behind the furniture
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    turn = about_z(room.yaw_rad)[:2, :2]
    floor = np.c_[corners @ turn.T, np.full(4, ground)]
    up = np.array([0.0, 0.0, WALL_M])
    walls = np.stack([[floor[k - 3], floor[k], floor[k] + up, floor[k - 3] + up] for k in range(4)])
    furniture = [_moved(part, room.yaw_rad, 0.0, ground) for part in parts]
    if is_plate:
        legs = trestle(low, np.array([*high[:2], low[2] - ground]))
        furniture.append(_moved(legs, 0.0, 0.0, ground))
    colors = sorted({part.color for part in furniture})
    merged = tuple(joined([part for part in furniture if part.color == color]) for color in colors)
    return RoomMeshes(floor=floor, floor_flat_m=corners, walls=walls, furniture=merged)


def _moved(part: Part, angle_rad: float, out_m: float, up_m: float = 0.0) -> Part:
    """The part moved by `out_m` along x and `up_m` along z, then turned about z."""
    moved = (part.vertices_m + np.array([out_m, 0.0, up_m])) @ about_z(angle_rad).T
    return Part(part.color, moved, part.faces)
