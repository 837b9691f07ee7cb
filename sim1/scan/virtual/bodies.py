"""Geometry of supports: lofted tubes of elliptic sections (a mannequin's torso and arms) and a rack board."""

import numpy as np

from sim1.scan.cloud import Shape


def loft(centres: np.ndarray, across: np.ndarray, along: np.ndarray, segments: int = 48) -> Shape:
    """Closed tube through ellipses.

    Args:
        centres: (k, 3) m, middle of each ellipse.
        across, along: (k, 3) m, its two half axes; the tube runs towards across x along.
        segments: points around.
    """
    angle = np.arange(segments) / segments * 2 * np.pi
    rings = centres[:, None] + np.cos(angle)[:, None] * across[:, None] + np.sin(angle)[:, None] * along[:, None]
    vertices = np.concatenate([rings.reshape(-1, 3), centres[[0, -1]]])
    k, j = np.meshgrid(np.arange(len(centres) - 1), np.arange(segments), indexing="ij")
    a, b = (k * segments + j).ravel(), (k * segments + (j + 1) % segments).ravel()
    j = np.arange(segments)
    top = (len(centres) - 1) * segments
    faces = np.concatenate([
        np.stack([a, b, b + segments], axis=1),
        np.stack([a, b + segments, a + segments], axis=1),
        np.stack([(j + 1) % segments, j, np.full(segments, len(vertices) - 2)], axis=1),
        np.stack([top + j, top + (j + 1) % segments, np.full(segments, len(vertices) - 1)], axis=1),
    ])  # fmt: skip
    return Shape(vertices_m=vertices, faces=faces.astype(np.int32))


def tube(points: np.ndarray, radii: np.ndarray) -> Shape:
    """Round tube along a nearly straight line: points (k, 3) m, radii (k,) m; its ends are rounded off."""
    direction = (points[-1] - points[0]) / np.linalg.norm(points[-1] - points[0])
    side = np.cross(direction, [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    bow = np.sin(np.linspace(0, np.pi / 2, 6)[1:])
    sink = np.cos(np.linspace(0, np.pi / 2, 6)[1:])
    start = [points[0] - direction * radii[0] * s for s in sink]
    end = [points[-1] + direction * radii[-1] * s for s in sink[::-1]]
    line = np.array([*start, *points[1:-1], *end])
    size = np.concatenate([radii[0] * bow, radii[1:-1], radii[-1] * bow[::-1]])[:, None]
    return loft(line, side * size, np.cross(direction, side) * size)


def board(size_m: tuple[float, float], thickness_m: float, bend_radius_m: float, cells: int = 24) -> Shape:
    """Rack board bent about the y axis, its top at z = 0 in the middle."""
    x, y = np.meshgrid(
        np.linspace(-0.5, 0.5, cells + 1) * size_m[0], np.linspace(-0.5, 0.5, cells + 1) * size_m[1], indexing="ij"
    )
    return slab(x, y, bend_radius_m, thickness_m)


def slab(x: np.ndarray, y: np.ndarray, bend_radius_m: float, thickness_m: float) -> Shape:
    """Bent sheet of grid points (arc length x, y); closed with a second side below where it has a thickness."""
    top = bend(x, y, 0.0, bend_radius_m)
    rows, columns = x.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1].ravel(), index[1:, :-1].ravel(), index[1:, 1:].ravel(), index[:-1, 1:].ravel()
    sheet = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    if not thickness_m:
        return Shape(vertices_m=top.reshape(-1, 3), faces=sheet.astype(np.int32))
    low = bend(x, y, -thickness_m, bend_radius_m)
    rim = np.concatenate([index[0, :-1], index[:-1, -1], index[-1, :0:-1], index[:0:-1, 0]])  # clockwise from above
    after = np.roll(rim, -1)
    n = rows * columns
    wall = np.concatenate([np.stack([rim, after, rim + n], axis=1), np.stack([after, after + n, rim + n], axis=1)])
    return Shape(
        vertices_m=np.concatenate([top.reshape(-1, 3), low.reshape(-1, 3)]),
        faces=np.concatenate([sheet, sheet[:, ::-1] + n, wall]).astype(np.int32),
    )


def bend(x: np.ndarray, y: np.ndarray, height: np.ndarray | float, radius_m: float) -> np.ndarray:
    """Points at arc length x and y on a cylinder about the y direction, `height` above it: (..., 3)."""
    angle = x / radius_m
    reach = radius_m + height
    return np.stack([reach * np.sin(angle), y + 0 * x, reach * np.cos(angle) - radius_m], axis=-1)


def joined(*shapes: Shape) -> Shape:
    """Several meshes as one."""
    offsets = np.cumsum([0, *(len(shape.vertices_m) for shape in shapes[:-1])])
    return Shape(
        vertices_m=np.concatenate([shape.vertices_m for shape in shapes]),
        faces=np.concatenate([shape.faces + offset for shape, offset in zip(shapes, offsets, strict=True)]).astype(
            np.int32
        ),
    )
