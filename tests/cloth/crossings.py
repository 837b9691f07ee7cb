"""Where a triangle mesh passes through itself."""

import numpy as np
from scipy.spatial import cKDTree

from sim1.cloth.garment import unique_edges


def crossings(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Pairs (n, 2) of edge and face that cut through each other and share no vertex."""
    points = points.astype(float)
    edges = unique_edges(faces)
    middle, centre = points[edges].mean(axis=1), points[faces].mean(axis=1)
    reach = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1).max()
    near = cKDTree(centre).query_ball_point(middle, 1.2 * reach)
    pairs = np.array([(e, f) for e, found in enumerate(near) for f in found])
    edge, face = edges[pairs[:, 0]], faces[pairs[:, 1]]
    apart = ~(edge[:, :, None] == face[:, None, :]).any(axis=(1, 2))
    pairs, edge, face = pairs[apart], edge[apart], face[apart]
    start, way = points[edge[:, 0]], points[edge[:, 1]] - points[edge[:, 0]]
    corner = points[face[:, 0]]
    first, second = points[face[:, 1]] - corner, points[face[:, 2]] - corner
    across = np.cross(way, second)
    scale = np.einsum("ij,ij->i", first, across)
    flat = np.abs(scale) < 1e-16
    scale = np.where(flat, 1.0, scale)
    from_corner = start - corner
    u = np.einsum("ij,ij->i", from_corner, across) / scale
    turned = np.cross(from_corner, first)
    v = np.einsum("ij,ij->i", way, turned) / scale
    t = np.einsum("ij,ij->i", second, turned) / scale
    cut = ~flat & (u > 0) & (v > 0) & (u + v < 1) & (t > 0) & (t < 1)
    return pairs[cut]
