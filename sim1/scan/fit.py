"""Moves the vertices of a coarse mesh off the surface so that its faces lie in the middle of it."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.remesh import corner_angles_rad
from sim1.scan.surface import closest_points

_SAMPLES = 30_000
_DAMPING = 0.3  # holds a vertex in place against about a tenth of a sample's pull


def fitted(mesh: Shape, dense: Shape, angle_rad: float, rounds: int = 3) -> Shape:
    """Least squares of the distances from the dense surface to the faces, over shifts of the vertices along their normals.

    Vertices on a curved surface span chords inside of it: a sleeve gets thinner, a garment smaller. A round that would make
    an angle smaller than `angle_rad` is not taken.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import lsqr

    vertices, faces = mesh.vertices_m.astype(float), mesh.faces
    samples = dense.vertices_m[:: max(1, len(dense.vertices_m) // _SAMPLES)]
    for _ in range(rounds):
        closest, face, _ = closest_points(samples, vertices, faces)
        corners = vertices[faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.zeros_like(vertices)
        for k in range(3):
            np.add.at(normals, faces[:, k], cross)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        flat = cross[face] / np.linalg.norm(cross[face], axis=1, keepdims=True)
        parts = [np.cross(corners[face, (k + 1) % 3] - closest, corners[face, (k + 2) % 3] - closest) for k in range(3)]
        size = (cross[face] ** 2).sum(axis=1)
        values = np.stack(
            [
                (part * cross[face]).sum(axis=1) / size * (normals[faces[face, k]] * flat).sum(axis=1)
                for k, part in enumerate(parts)
            ]
        )
        rows = np.tile(np.arange(len(samples)), 3)
        system = coo_matrix((values.ravel(), (rows, faces[face].T.ravel())), shape=(len(samples), len(vertices)))
        shift = lsqr(system.tocsr(), ((samples - closest) * flat).sum(axis=1), damp=_DAMPING)[0]
        moved = vertices + shift[:, None] * normals
        if corner_angles_rad(moved, faces).min() < angle_rad:
            break
        vertices = moved
    return Shape(vertices_m=vertices, faces=faces)
