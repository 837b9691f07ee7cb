"""Cloth that went through itself: edges that pass through faces."""

import numpy as np
from scipy.spatial import KDTree

from sim1.cloth.garment import unique_edges


def crossings(garment_m: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Pairs (k, 2) of an edge (row of `unique_edges`) and a face that it passes through, sharing no vertex with it.

    Source: Moeller and Trumbore 1997, for all pairs whose middles are near enough to meet.

    Args:
        garment_m: (v, 3)
        faces: (f, 3)
    """
    edges = unique_edges(faces)
    a, b = garment_m[edges[:, 0]], garment_m[edges[:, 1]]
    corners = garment_m[faces]
    middle, reach = corners.mean(axis=1), np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(1)
    half = 0.5 * np.linalg.norm(b - a, axis=1)
    near = KDTree(middle).query_ball_point(0.5 * (a + b), half + reach.max())
    edge = np.repeat(np.arange(len(edges)), [len(found) for found in near])
    face = np.concatenate([np.array(found, int) for found in near]) if len(edge) else np.zeros(0, int)
    apart = (edges[edge][:, :, None] != faces[face][:, None, :]).all(axis=(1, 2))
    edge, face = edge[apart], face[apart]
    way, origin = b[edge] - a[edge], corners[face, 0]
    side, other = corners[face, 1] - origin, corners[face, 2] - origin
    normal = np.cross(way, other)
    size = (side * normal).sum(axis=1)
    flat = np.abs(size) < 1e-18  # an edge in the plane of a face does not pass through it
    size = np.where(flat, 1.0, size)
    from_corner = a[edge] - origin
    u = (from_corner * normal).sum(axis=1) / size
    turned = np.cross(from_corner, side)
    v = (way * turned).sum(axis=1) / size
    share = (other * turned).sum(axis=1) / size
    through = ~flat & (u > 0) & (v > 0) & (u + v < 1) & (share > 0) & (share < 1)
    return np.stack([edge[through], face[through]], axis=1)
