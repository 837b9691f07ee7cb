"""Furniture made of boxes and cylinders, a few dozen faces each: background, never handled.

Every function gives the parts of a piece that stands on z = 0 with its front in the plane x = 0 and its body at x > 0, facing -x.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import trimesh

from sim1.render.looks.blocks import Kinds, Limits

SIDES = 12  # of a cylinder: it is seen from metres away
BODY, TOP, DETAIL = range(3)  # index into the room's furniture colours
SIZE: Limits = (0.05, 4.0)  # m
FURNITURE = Kinds("furniture")


@dataclass(frozen=True)
class Part:
    """A mesh of one colour."""

    color: int
    vertices_m: np.ndarray  # (v, 3)
    faces: np.ndarray  # (f, 3)


def _box(color: int, low: tuple[float, float, float], high: tuple[float, float, float]) -> Part:
    mesh = trimesh.creation.box(bounds=np.array([low, high]))
    return Part(color, np.asarray(mesh.vertices), np.asarray(mesh.faces))


def _cylinder(color: int, middle: tuple[float, float], z: tuple[float, float], radii: tuple[float, float]) -> Part:
    """Upright, with a radius below and one above."""
    angle = np.arange(SIDES) * 2.0 * np.pi / SIDES
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rims = [np.c_[ring * radius + middle, np.full(SIDES, height)] for radius, height in zip(radii, z)]
    ends = [[*middle, height] for height in z]
    i, j = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    low, high = 2 * SIDES, 2 * SIDES + 1
    faces = np.concatenate(
        [
            np.c_[i, j, j + SIDES],
            np.c_[i, j + SIDES, i + SIDES],
            np.c_[j, i, np.full(SIDES, low)],
            np.c_[i + SIDES, j + SIDES, np.full(SIDES, high)],
        ]
    )
    return Part(color, np.concatenate([*rims, ends]), faces)


def _legs(color: int, depth: float, width: float, height: float, thick: float) -> list[Part]:
    return [
        _box(color, (x, y, 0.0), (x + thick, y + thick, height))
        for x in (0.0, depth - thick)
        for y in (-width / 2, width / 2 - thick)
    ]


@FURNITURE.kind(width_m=SIZE, depth_m=SIZE, height_m=SIZE)
def cabinet(*, width_m: float, depth_m: float, height_m: float) -> list[Part]:
    """Doors of about 0.5 m with handles on a plinth, a top that overhangs."""
    doors = max(1, round(width_m / 0.5))
    edges = np.linspace(-width_m / 2, width_m / 2, doors + 1)
    parts = [
        _box(DETAIL, (0.05, -width_m / 2, 0.0), (depth_m, width_m / 2, 0.09)),
        _box(BODY, (0.02, -width_m / 2, 0.09), (depth_m, width_m / 2, height_m - 0.03)),
        _box(TOP, (0.0, -width_m / 2 - 0.01, height_m - 0.03), (depth_m, width_m / 2 + 0.01, height_m)),
    ]
    for left, right in pairwise(edges):
        parts.append(_box(BODY, (0.005, left + 0.004, 0.1), (0.02, right - 0.004, height_m - 0.04)))
        handle = (right - 0.06, right - 0.045)
        parts.append(_box(DETAIL, (-0.02, handle[0], 0.45 * height_m), (0.005, handle[1], 0.65 * height_m)))
    return parts


@FURNITURE.kind(width_m=SIZE, depth_m=SIZE, height_m=SIZE)
def desk(*, width_m: float, depth_m: float, height_m: float) -> list[Part]:
    """A top on four legs, with a drawer unit at one side."""
    return [
        *_legs(DETAIL, depth_m, width_m, height_m - 0.03, 0.05),
        _box(TOP, (0.0, -width_m / 2, height_m - 0.03), (depth_m, width_m / 2, height_m)),
        _box(BODY, (0.05, width_m / 2 - 0.45, 0.05), (depth_m - 0.05, width_m / 2 - 0.06, height_m - 0.03)),
    ]


@FURNITURE.kind(width_m=SIZE, height_m=SIZE)
def chair(*, width_m: float, height_m: float) -> list[Part]:
    """Four legs, a seat, a back away from the table."""
    seat = 0.5 * height_m
    return [
        *_legs(DETAIL, width_m, width_m, seat, 0.035),
        _box(BODY, (0.0, -width_m / 2, seat), (width_m, width_m / 2, seat + 0.04)),
        _box(BODY, (width_m - 0.03, -width_m / 2, seat + 0.15), (width_m, width_m / 2, height_m)),
        _box(DETAIL, (width_m - 0.03, -width_m / 2, seat), (width_m, -width_m / 2 + 0.03, height_m)),
        _box(DETAIL, (width_m - 0.03, width_m / 2 - 0.03, seat), (width_m, width_m / 2, height_m)),
    ]


@FURNITURE.kind(width_m=SIZE, height_m=SIZE)
def stool(*, width_m: float, height_m: float) -> list[Part]:
    """A round seat on a column."""
    middle = (width_m / 2, 0.0)
    return [
        _cylinder(DETAIL, middle, (0.0, 0.03), (width_m / 2, width_m / 2.2)),
        _cylinder(DETAIL, middle, (0.03, height_m - 0.05), (0.03, 0.03)),
        _cylinder(BODY, middle, (height_m - 0.05, height_m), (width_m / 2, width_m / 2)),
    ]


@FURNITURE.kind(width_m=SIZE, depth_m=SIZE, height_m=SIZE)
def shelf(*, width_m: float, depth_m: float, height_m: float) -> list[Part]:
    """Boards between two sides, with boxes on them."""
    count = max(2, round(height_m / 0.4))
    levels = np.linspace(0.06, height_m, count + 1)
    parts = [_box(BODY, (0.0, y, 0.0), (depth_m, y + 0.02, height_m)) for y in (-width_m / 2, width_m / 2 - 0.02)] + [
        _box(BODY, (0.0, -width_m / 2, z - 0.02), (depth_m, width_m / 2, z)) for z in levels
    ]
    for number, z in enumerate(levels[:-1]):
        y = (-0.4 + 0.27 * (number % 3)) * width_m
        high = z + 0.6 * (levels[1] - levels[0])
        parts.append(_box((TOP, DETAIL)[number % 2], (0.04, y, z), (depth_m - 0.03, y + 0.28 * width_m, high)))
    return parts


@FURNITURE.kind(width_m=SIZE, depth_m=SIZE)
def sofa(*, width_m: float, depth_m: float) -> list[Part]:
    """Seat, back, two arms, two cushions."""
    back, arm = 0.22 * depth_m, 0.12 * width_m
    return [
        _box(BODY, (0.0, -width_m / 2, 0.08), (depth_m, width_m / 2, 0.42)),
        _box(BODY, (depth_m - back, -width_m / 2, 0.42), (depth_m, width_m / 2, 0.8)),
        *(_box(BODY, (0.0, y, 0.42), (depth_m - back, y + arm, 0.6)) for y in (-width_m / 2, width_m / 2 - arm)),
        *(
            _box(TOP, (0.3 * depth_m, y, 0.42), (0.5 * depth_m, y + 0.4, 0.75))
            for y in (-0.3 * width_m, 0.05 * width_m)
        ),
        *_legs(DETAIL, depth_m, width_m, 0.08, 0.06),
    ]


@FURNITURE.kind(width_m=SIZE, depth_m=SIZE)
def bed(*, width_m: float, depth_m: float) -> list[Part]:
    """A frame, a mattress with a blanket folded back, pillows."""
    pillow = 0.38 * width_m
    return [
        _box(DETAIL, (0.0, -width_m / 2, 0.1), (depth_m, width_m / 2, 0.28)),
        _box(TOP, (0.03, -width_m / 2 + 0.02, 0.28), (depth_m - 0.05, width_m / 2 - 0.02, 0.48)),
        _box(BODY, (0.02, -width_m / 2 - 0.02, 0.2), (0.62 * depth_m, width_m / 2 + 0.02, 0.52)),
        _box(DETAIL, (depth_m - 0.05, -width_m / 2, 0.1), (depth_m, width_m / 2, 0.95)),
        *(
            _box(TOP, (0.78 * depth_m, y, 0.48), (0.94 * depth_m, y + pillow, 0.6))
            for y in (-0.45 * width_m, 0.07 * width_m)
        ),
    ]


@FURNITURE.kind(width_m=SIZE, height_m=SIZE)
def washer(*, width_m: float, height_m: float) -> list[Part]:
    """A box with a round door, panel and dispenser."""
    door = _cylinder(DETAIL, (0.0, 0.0), (-0.03, 0.0), (0.3 * width_m, 0.34 * width_m))
    turned = door.vertices_m[:, [2, 1, 0]] + [0.0, 0.0, 0.47 * height_m]
    return [
        _box(TOP, (0.0, -width_m / 2, 0.0), (width_m, width_m / 2, height_m)),
        Part(door.color, turned, door.faces[:, ::-1]),
        _box(DETAIL, (-0.008, -0.1 * width_m, 0.87 * height_m), (0.0, 0.45 * width_m, 0.95 * height_m)),
        _box(BODY, (-0.008, -0.45 * width_m, 0.87 * height_m), (0.0, -0.2 * width_m, 0.95 * height_m)),
    ]


@FURNITURE.kind(width_m=SIZE, depth_m=SIZE, height_m=SIZE)
def carton(*, width_m: float, depth_m: float, height_m: float) -> list[Part]:
    """A closed box with tape over its edge."""
    tape = 0.03
    return [
        _box(TOP, (0.0, -width_m / 2, 0.0), (depth_m, width_m / 2, height_m)),
        _box(DETAIL, (-0.002, -tape, 0.6 * height_m), (depth_m / 2, tape, height_m + 0.002)),
    ]


@FURNITURE.kind(width_m=SIZE, height_m=SIZE)
def basket(*, width_m: float, height_m: float) -> list[Part]:
    """A round basket or bin with a rim."""
    middle = (width_m / 2, 0.0)
    return [
        _cylinder(BODY, middle, (0.0, height_m), (0.38 * width_m, 0.48 * width_m)),
        _cylinder(DETAIL, middle, (height_m, height_m + 0.02), (width_m / 2, width_m / 2)),
    ]


@FURNITURE.kind(width_m=SIZE, height_m=SIZE)
def plant(*, width_m: float, height_m: float) -> list[Part]:
    """A pot with leaves that stand out in all directions."""
    middle, pot = (width_m / 2, 0.0), 0.3 * height_m
    parts = [_cylinder(TOP, middle, (0.0, pot), (0.22 * width_m, 0.3 * width_m))]
    for number in range(9):
        angle, lean = 2.4 * number, 0.25 + 0.25 * (number % 3) / 2
        out, side = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([-np.sin(angle), np.cos(angle), 0.0])
        foot = np.array([*middle, pot])
        bend = foot + 0.35 * lean * width_m * out + [0.0, 0.0, 0.5 * (height_m - pot)]
        tip = foot + lean * width_m * out + [0.0, 0.0, (1.0 - 0.6 * lean) * (height_m - pot)]
        half = 0.09 * width_m * side
        parts.append(Part(DETAIL, np.array([foot, bend - half, bend + half, tip]), np.array([[0, 1, 2], [1, 3, 2]])))
    return parts


@FURNITURE.kind(width_m=SIZE, depth_m=SIZE)
def rug(*, width_m: float, depth_m: float) -> list[Part]:
    """Two flat rectangles, one with a border around the other."""
    edge = 0.08
    return [
        _box(BODY, (0.0, -width_m / 2, 0.0), (depth_m, width_m / 2, 0.008)),
        _box(TOP, (edge, -width_m / 2 + edge, 0.008), (depth_m - edge, width_m / 2 - edge, 0.012)),
    ]


def trestle(low_m: np.ndarray, high_m: np.ndarray) -> Part:
    """Four legs below a table top whose underside's corners are `low_m` and `high_m` (3,), from z = 0 to `high_m[2]`."""
    thick, inset = 0.06, 0.04
    parts = [
        _box(DETAIL, (x, y, 0.0), (x + thick, y + thick, high_m[2]))
        for x in (low_m[0] + inset, high_m[0] - inset - thick)
        for y in (low_m[1] + inset, high_m[1] - inset - thick)
    ]
    return joined(parts)


def joined(parts: list[Part]) -> Part:
    """One mesh of several, with the first one's colour."""
    starts = np.cumsum([0, *(len(part.vertices_m) for part in parts)])
    return Part(
        parts[0].color,
        np.concatenate([part.vertices_m for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts)]),
    )
