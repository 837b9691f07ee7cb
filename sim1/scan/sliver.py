"""Removes slivers from a simulation mesh: collapses needles, flips caps, evens out the vertices on the dense surface."""

import numpy as np
from scipy.spatial import cKDTree

from sim1.scan.cloud import Shape
from sim1.scan.remesh import corner_angles_rad
from sim1.scan.rims import rim_edges
from sim1.scan.surface import closest_points

_CORNER_COS = np.cos(np.radians(40.0))  # a rim that turns by more is a corner of the garment, which stays


def without_slivers(mesh: Shape, dense: Shape, angle_rad: float, rounds: int = 40) -> Shape:
    """Raise the smallest angle above `angle_rad` by local operations; topology and rims are kept.

    Args:
        mesh: remeshed surface.
        dense: the surface that it approximates; vertices stay on it, those of rims on its rims.
        angle_rad: the smallest angle wanted. The result may fall short of it: check it.
        rounds: at most so many rounds of operations and smoothing.
    """
    vertices, faces = mesh.vertices_m.astype(float), mesh.faces.astype(np.int64)
    rim = dense.vertices_m[np.unique(rim_edges(dense.faces))]
    for _ in range(rounds):
        vertices = _evened(vertices, faces, dense, rim)
        if corner_angles_rad(vertices, faces).min() > angle_rad:
            break
        vertices, faces = _operate(vertices, faces, 1.2 * angle_rad)
        used, packed = np.unique(faces, return_inverse=True)
        vertices, faces = vertices[used], packed.reshape(-1, 3)
    return Shape(vertices_m=vertices, faces=faces.astype(np.int32))


def _operate(vertices: np.ndarray, faces: np.ndarray, limit: float) -> tuple[np.ndarray, np.ndarray]:
    """One pass over the faces below the limit, worst first; a face whose neighbourhood has changed waits for the next pass."""
    vertices, faces = vertices.copy(), faces.copy()
    angles = corner_angles_rad(vertices, faces)
    alive = np.ones(len(faces), bool)
    touched = np.zeros(len(vertices), bool)
    for index in np.argsort(angles.min(axis=1)):
        if angles[index].min() >= limit:
            break
        if not alive[index] or touched[faces[index]].any():
            continue
        for operation in (_flip, _collapse):
            if changed := operation(vertices, faces, alive, index):
                touched[changed] = True
                break
    return vertices, faces[alive]


def _around(faces: np.ndarray, alive: np.ndarray, *corners: int) -> np.ndarray:
    """Living faces that hold all the given vertices."""
    hold = alive.copy()
    for corner in corners:
        hold &= (faces == corner).any(axis=1)
    return np.flatnonzero(hold)


def _flip(vertices: np.ndarray, faces: np.ndarray, alive: np.ndarray, index: int) -> list[int]:
    """Replace the longest edge of a face by the other diagonal, where that raises the smaller of the angles."""
    face = faces[index]
    length = np.linalg.norm(vertices[face[[1, 2, 0]]] - vertices[face], axis=1)
    k = int(length.argmax())
    a, b, c = (int(face[(k + j) % 3]) for j in range(3))
    pair = _around(faces, alive, a, b)
    if len(pair) != 2:
        return []
    other = pair[pair != index][0]
    d = int(faces[other][~np.isin(faces[other], (a, b))][0])
    if len(_around(faces, alive, c, d)):
        return []
    new = np.array([(c, a, d), (c, d, b)])
    if not _better(vertices, faces[[index, other]], new):
        return []
    faces[[index, other]] = new
    return [a, b, c, d]


def _collapse(vertices: np.ndarray, faces: np.ndarray, alive: np.ndarray, index: int) -> list[int]:
    """Collapse the shortest edge of a face, if the surface stays a manifold and no angle gets worse than the worst."""
    face = faces[index]
    length = np.linalg.norm(vertices[face[[1, 2, 0]]] - vertices[face], axis=1)
    on_rim = np.zeros(len(vertices), bool)
    on_rim[rim_edges(faces[alive]).ravel()] = True
    for k in np.argsort(length):
        a, b = int(face[k]), int(face[(k + 1) % 3])
        gone, ring_a, ring_b = _around(faces, alive, a, b), _around(faces, alive, a), _around(faces, alive, b)
        shared = np.setdiff1d(np.intersect1d(faces[ring_a], faces[ring_b]), (a, b))
        if len(shared) != len(gone) or (on_rim[a] and on_rim[b] and len(gone) == 2):
            continue  # it would pinch the surface
        for place in _places(vertices, on_rim, a, b):
            moved = vertices.copy()
            moved[[a, b]] = place
            ring = np.setdiff1d(np.union1d(ring_a, ring_b), gone)
            new = np.where(faces[ring] == b, a, faces[ring])
            if _better(vertices, faces[np.union1d(ring, gone)], new, faces[ring], moved):
                vertices[a] = place
                faces[ring], alive[gone] = new, False
                return [int(v) for v in np.unique(new)] + [b]
    return []


def _places(vertices: np.ndarray, on_rim: np.ndarray, a: int, b: int) -> list[np.ndarray]:
    if on_rim[a] != on_rim[b]:
        return [vertices[a] if on_rim[a] else vertices[b]]
    return [(vertices[a] + vertices[b]) / 2, vertices[a], vertices[b]]


def _better(
    vertices: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
    turned: np.ndarray | None = None,
    moved: np.ndarray | None = None,
) -> bool:
    """The smallest angle grows, and no face turns over."""
    moved = vertices if moved is None else moved
    if not len(after) or corner_angles_rad(moved, after).min() <= corner_angles_rad(vertices, before).min():
        return False
    old = _normals(vertices, before if turned is None else turned)
    new = _normals(moved, after)
    return bool(((old if turned is not None else old.mean(axis=0)) * new).sum(axis=-1).min() > 0.3)


def _normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = vertices[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return cross / np.maximum(np.linalg.norm(cross, axis=1, keepdims=True), 1e-20)


def _evened(vertices: np.ndarray, faces: np.ndarray, dense: Shape, rim: np.ndarray, steps: int = 3) -> np.ndarray:
    """Tangential smoothing: each vertex towards the mean of its neighbours, back on the dense surface; rims along themselves."""
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    border = rim_edges(faces)
    on_rim = np.zeros(len(vertices), bool)
    on_rim[border.ravel()] = True
    after, before = np.full(len(vertices), -1), np.full(len(vertices), -1)
    after[border[:, 0]], before[border[:, 1]] = border[:, 1], border[:, 0]
    edge_of = np.flatnonzero(on_rim)
    tree = cKDTree(rim)
    for _ in range(steps):
        total, count = np.zeros_like(vertices), np.bincount(edges.ravel(), minlength=len(vertices))
        for a, b in ((0, 1), (1, 0)):
            np.add.at(total, edges[:, a], vertices[edges[:, b]])
        inner = ~on_rim
        target = vertices.copy()
        target[inner] += 0.5 * (total[inner] / count[inner, None] - vertices[inner])
        target[inner], _, _ = closest_points(target[inner], dense.vertices_m, dense.faces)
        into, out = vertices[edge_of] - vertices[before[edge_of]], vertices[after[edge_of]] - vertices[edge_of]
        sizes = np.linalg.norm(into, axis=1), np.linalg.norm(out, axis=1)
        straight = (into * out).sum(axis=1) > _CORNER_COS * sizes[0] * sizes[1]
        slide = edge_of[straight]
        middle = vertices[slide] + 0.25 * (out - into)[straight]
        target[slide] = rim[tree.query(middle)[1]]
        vertices = target
    return vertices
