"""Garment shapes as zero sets: a function of space that is negative inside, meshed, and cut open by planes."""

from collections.abc import Callable

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.pieces import largest_piece
from sim1.scan.poisson import poisson

type Field = Callable[[np.ndarray], np.ndarray]
"""Points (n, 3) m to a value (n,) that is about the distance (m) to the surface near it, negative inside."""

type Point = tuple[float, float, float]

_GRID_M = 0.007
_STEP_M = 1.0e-4


def zero_set(field: Field, low: Point, high: Point, cell_m: float = 0.007) -> Shape:
    """Closed mesh of field = 0 within a box, by Newton steps onto it and a Poisson surface through where they end."""
    axes = [np.arange(a, b, _GRID_M) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[np.abs(field(points)) < 1.5 * _GRID_M]
    for _ in range(8):
        slope = _gradient(field, points)
        points = points - (field(points) / np.maximum((slope**2).sum(axis=1), 1e-3))[:, None] * slope
    points = points[np.abs(field(points)) < 1e-5]
    slope = _gradient(field, points)
    return poisson(points, slope / np.linalg.norm(slope, axis=1, keepdims=True), cell_m)


def cut(shape: Shape, origin: Point, normal: Point, beyond_y_m: float = -np.inf, side: float = 1.0) -> Shape:
    """The part of a mesh on the side that `normal` points to, open along the cut.

    Faces with side * y below `beyond_y_m` are kept whole: a sleeve's plane would go on through the body.
    """
    from trimesh.intersections import slice_faces_plane

    reach = side * shape.vertices_m[shape.faces].mean(axis=1)[:, 1] > beyond_y_m
    vertices, faces, _ = slice_faces_plane(
        shape.vertices_m, shape.faces[reach], np.array(normal, float), np.array(origin, float)
    )
    faces = np.concatenate([faces, shape.faces[~reach] + len(vertices)])
    vertices = np.concatenate([vertices, shape.vertices_m])
    _, first, same = np.unique(np.round(vertices, 7), axis=0, return_index=True, return_inverse=True)
    faces = same.ravel()[faces]
    kept = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return largest_piece(vertices[first], faces[kept])


def union(*values: np.ndarray, blend_m: float) -> np.ndarray:
    """Smooth minimum: shapes joined with a fillet of about `blend_m`."""
    stacked = np.stack(values) / -blend_m
    most = stacked.max(axis=0)
    return -blend_m * (most + np.log(np.exp(stacked - most).sum(axis=0)))


def ellipse(
    first: np.ndarray, second: np.ndarray, half_first: np.ndarray | float, half_second: np.ndarray | float
) -> np.ndarray:
    """About the distance to a tube of elliptic section, from the two coordinates across it (m)."""
    reach = np.sqrt((first / half_first) ** 2 + (second / half_second) ** 2 + 1e-12)
    return (reach - 1.0) * np.minimum(half_first, half_second)


def _gradient(field: Field, points: np.ndarray) -> np.ndarray:
    steps = np.eye(3) * _STEP_M
    return np.stack([(field(points + step) - field(points - step)) / (2 * _STEP_M) for step in steps], axis=1)
