"""A finer mesh of the same garment: every triangle cut at its longest edge, and its neighbour with it.

Vertices that were there stay what they were, in their order, so that whoever knows the garment by them need not know of the finer mesh.
The longest edge is the one to cut, as angles then stay away from zero (Rivara 1984).
"""

from dataclasses import dataclass

import numpy as np

from sim1.cloth.garment import GarmentMesh, checked_mesh, unique_edges


@dataclass(frozen=True, kw_only=True)
class Bisected:
    """A finer mesh, and where its further vertices come from."""

    mesh: GarmentMesh  # the first v vertices are the garment's
    parents: np.ndarray  # (n, 2) int: ends of the edges in whose middles the further ones lie

    def refined(self, points_m: np.ndarray) -> np.ndarray:
        """Vertices (v + n, 3) from those of the garment (v, 3): the further ones in the middle of their edges."""
        points = np.asarray(points_m)
        return np.concatenate([points, points[self.parents].mean(axis=1, dtype=float).astype(points.dtype)])


def bisected(garment: GarmentMesh) -> Bisected:
    """Cut every triangle at its longest edge in the rest shape.

    Where an edge is cut that is not the longest of the triangle on its other side, that one is cut at its longest and at this
    edge too: no vertex lies in the middle of an edge.
    """
    faces, rest = garment.faces.astype(int), garment.rest_m
    edges = unique_edges(faces)
    number = {tuple(edge): k for k, edge in enumerate(edges)}
    sides = np.array(
        [[number[tuple(sorted((a, b)))] for a, b in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))] for f in faces]
    )
    length = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    longest = sides[np.arange(len(faces)), np.argmax(length[sides], axis=1)]
    cut = np.unique(longest)
    middle = np.full(len(edges), -1)
    middle[cut] = len(rest) + np.arange(len(cut))
    finer: list[tuple[int, int, int]] = []
    for face, own, first in zip(faces, sides, longest, strict=True):
        turn = int(np.flatnonzero(own == first)[0])
        (a, b, c), (_, after, before) = np.roll(face, -turn), np.roll(own, -turn)  # a to b is the longest edge
        m = middle[first]
        finer += _halved(m, b, c, middle[after]) + _halved(m, c, a, middle[before])
    parents = edges[cut]
    vertices, flat = (np.concatenate([one, one[parents].mean(axis=1)]) for one in (garment.vertices_m, rest))
    return Bisected(mesh=checked_mesh(vertices, np.array(finer), flat, "bisected mesh"), parents=parents)


def _halved(m: int, low: int, high: int, between: int) -> list[tuple[int, int, int]]:
    """The triangle from the middle of the longest edge to another edge, or its halves where that is cut too (`between` is not -1)."""
    if between < 0:
        return [(m, low, high)]
    return [(m, low, between), (m, between, high)]
