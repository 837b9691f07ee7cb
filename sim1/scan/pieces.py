"""Pieces of a mesh: connected components, and what remains on one side of a cut."""

import numpy as np

from sim1.scan.cloud import Shape


def largest_piece(vertices: np.ndarray, faces: np.ndarray) -> Shape:
    """The connected component with most faces, without vertices that no face uses."""
    label = face_components(faces, np.ones(len(faces), bool))
    faces = faces[label == np.bincount(label).argmax()]
    used, packed = np.unique(faces, return_inverse=True)
    return Shape(vertices_m=vertices[used], faces=packed.reshape(-1, 3).astype(np.int32))


def face_components(faces: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Label (f,) of the edge-connected component of each face of `among`, -1 for the others."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from trimesh.graph import face_adjacency

    pairs = face_adjacency(faces)
    pairs = pairs[among[pairs].all(axis=1)]
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(faces),) * 2)
    _, label = connected_components(graph, directed=False)
    result = np.full(len(faces), -1)
    _, result[among] = np.unique(label[among], return_inverse=True)
    return result


def clip(shape: Shape, value: np.ndarray) -> Shape:
    """The part of a surface where a value (v,) per vertex is positive, cut straight through the triangles."""
    value = np.where(value == 0, 1e-12, value)
    inside = (value > 0)[shape.faces]
    count = inside.sum(axis=1)
    edges = np.sort(shape.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges = np.unique(edges[(value[edges[:, 0]] > 0) != (value[edges[:, 1]] > 0)], axis=0)
    part = (value[edges[:, 0]] / (value[edges[:, 0]] - value[edges[:, 1]]))[:, None]
    crossings = (1 - part) * shape.vertices_m[edges[:, 0]] + part * shape.vertices_m[edges[:, 1]]
    size = len(shape.vertices_m)
    keys = edges[:, 0].astype(np.int64) * size + edges[:, 1]

    def crossing(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return size + np.searchsorted(keys, np.minimum(a, b).astype(np.int64) * size + np.maximum(a, b))

    def turned(which: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, ...]:
        rows = np.flatnonzero(which)
        return tuple(shape.faces[rows, (first[rows] + k) % 3] for k in range(3))

    a, b, c = turned(count == 1, inside.argmax(axis=1))  # a alone is inside
    one = np.stack([a, crossing(a, b), crossing(a, c)], axis=1)
    a, b, c = turned(count == 2, inside.argmin(axis=1))  # a alone is outside
    two = [np.stack([b, c, crossing(a, b)], axis=1), np.stack([c, crossing(a, c), crossing(a, b)], axis=1)]
    faces = np.concatenate([shape.faces[count == 3], one, *two])
    return largest_piece(np.concatenate([shape.vertices_m, crossings]), faces)
