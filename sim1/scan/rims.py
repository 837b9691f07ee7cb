"""Rims of an open surface: where they run, how long they are, and where the fabric really ends."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.pieces import clip


def rim_edges(faces: np.ndarray) -> np.ndarray:
    """Edges of one face only, in the direction of that face: (e, 2)."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key = np.sort(edges, axis=1)
    _, index, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    return edges[count[index.ravel()] == 1]


def rim_lengths_m(vertices: np.ndarray, faces: np.ndarray) -> list[float]:
    """Lengths of the boundary loops, longest first."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    edges = rim_edges(faces)
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(len(vertices),) * 2)
    _, label = connected_components(graph, directed=False)
    length = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    sums = np.bincount(label[edges[:, 0]], length)
    return sorted((float(value) for value in sums[sums > 0]), reverse=True)


def smooth_rims(shape: Shape, steps: int = 60) -> np.ndarray:
    """Vertices with the saw-tooth of the rims ironed out along each rim (Taubin), the rest as it was: (v, 3)."""
    vertices = shape.vertices_m.copy()
    edges = rim_edges(shape.faces)
    if not len(edges):
        return vertices
    count = np.bincount(edges.ravel(), minlength=len(vertices))[:, None]
    on_rim = count[:, 0] > 0
    for step in range(2 * steps):
        total = np.zeros_like(vertices)
        for a, b in ((0, 1), (1, 0)):
            np.add.at(total, edges[:, a], vertices[edges[:, b]])
        pull = total[on_rim] / count[on_rim] - vertices[on_rim]
        vertices[on_rim] += pull * (0.5 if step % 2 == 0 else -0.51)
    return vertices


def rim_overshoot_m(shape: Shape, points: np.ndarray, spacing_m: float) -> float:
    """How far the rims lie outside of the edge of the fabric, from their distances to the nearest points.

    With points spread at random over a half plane, the nearest one to a place h outside of its edge is farther than r with
    probability exp(-density A(r, h)), A the part of the disc of radius r beyond the edge. h follows from the median of r.

    Args:
        shape: surface with smooth rims.
        points: (n, 3) m.
        spacing_m: median distance of a point to its 4th neighbour, which gives the density: 4 / (pi spacing^2).
    """
    from scipy.optimize import brentq
    from scipy.spatial import cKDTree

    rim = np.unique(rim_edges(shape.faces))
    if not len(rim):
        return 0.0
    reach = float(np.median(cKDTree(points).query(shape.vertices_m[rim])[0]))
    area = np.log(2.0) * np.pi / 4 * spacing_m**2

    def missing(h: float) -> float:
        return reach**2 * np.arccos(h / reach) - h * np.sqrt(reach**2 - h**2) - area

    return float(brentq(missing, 0.0, reach)) if missing(0.0) > 0 else 0.0


def inset(shape: Shape, by_m: float) -> Shape:
    """The surface without a strip of width `by_m` along its rims."""
    from scipy.spatial import cKDTree

    ends = shape.vertices_m[rim_edges(shape.faces)]
    if by_m <= 0 or not len(ends):
        return shape
    part = np.linspace(0, 1, 6)[:, None, None]
    line = ((1 - part) * ends[:, 0] + part * ends[:, 1]).reshape(-1, 3)
    return clip(shape, cKDTree(line).query(shape.vertices_m)[0] - by_m)
