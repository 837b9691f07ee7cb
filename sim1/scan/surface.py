"""Exact queries against a triangle mesh: closest points and ray hits, by warp's bounding-volume tree on the CPU."""

import numpy as np
import warp as wp

wp.config.log_level = wp.LOG_ERROR  # progress goes through sim1.progress, not to the terminal
_FAR = 1.0e3  # metres


@wp.kernel
def _closest(
    mesh: wp.uint64, points: wp.array(dtype=wp.vec3), closest: wp.array(dtype=wp.vec3), face: wp.array(dtype=int)
):
    i = wp.tid()
    found = wp.mesh_query_point_no_sign(mesh, points[i], _FAR)
    face[i] = -1
    if found.result:
        closest[i] = wp.mesh_eval_position(mesh, found.face, found.u, found.v)
        face[i] = found.face


@wp.kernel
def _cast(
    mesh: wp.uint64,
    start: wp.array(dtype=wp.vec3),
    direction: wp.array(dtype=wp.vec3),
    distance: wp.array(dtype=float),
    face: wp.array(dtype=int),
):
    i = wp.tid()
    found = wp.mesh_query_ray(mesh, start[i], direction[i], _FAR)
    face[i] = -1
    if found.result:
        distance[i] = found.t
        face[i] = found.face


def _mesh(vertices: np.ndarray, faces: np.ndarray) -> wp.Mesh:
    return wp.Mesh(
        points=wp.array(np.ascontiguousarray(vertices, np.float32), dtype=wp.vec3, device="cpu"),
        indices=wp.array(np.ascontiguousarray(faces, np.int32).ravel(), dtype=int, device="cpu"),
    )


def closest_points(
    points: np.ndarray, vertices: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closest point of a mesh to each point.

    Args:
        points: (n, 3) m.
        vertices, faces: the mesh, m.

    Returns:
        Closest points (n, 3), their faces (n,), distances (n,) m.
    """
    mesh = _mesh(vertices, faces)
    closest = wp.empty(len(points), dtype=wp.vec3, device="cpu")
    face = wp.empty(len(points), dtype=int, device="cpu")
    query = wp.array(np.ascontiguousarray(points, np.float32), dtype=wp.vec3, device="cpu")
    wp.launch(_closest, len(points), inputs=[mesh.id, query, closest, face], device="cpu")
    found = closest.numpy().astype(float)
    return found, face.numpy(), np.linalg.norm(found - points, axis=1)


def cast_rays(
    start: np.ndarray, direction: np.ndarray, vertices: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """First hit of each ray with a mesh.

    Args:
        start: (n, 3) m.
        direction: (n, 3) unit vectors.
        vertices, faces: the mesh, m.

    Returns:
        Distance (n,) m, infinite where nothing is hit; face (n,), -1 there.
    """
    mesh = _mesh(vertices, faces)
    distance = wp.full(len(start), np.inf, dtype=float, device="cpu")
    face = wp.empty(len(start), dtype=int, device="cpu")
    arrays = [wp.array(np.ascontiguousarray(a, np.float32), dtype=wp.vec3, device="cpu") for a in (start, direction)]
    wp.launch(_cast, len(start), inputs=[mesh.id, *arrays, distance, face], device="cpu")
    return distance.numpy().astype(float), face.numpy()
