"""Screened Poisson surface of oriented points, cut open again where the garment is open."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.pieces import clip, face_components
from sim1.stage import BadInput


def poisson(points: np.ndarray, normals: np.ndarray, cell_m: float) -> Shape:
    """Surface through points (n, 3) m with outward normals; Kazhdan & Hoppe 2013, octree cells of about `cell_m`.

    It has no rim but where it leaves the box around the points, far from any of them.
    """
    import pymeshlab

    side = float(np.ptp(points, axis=0).max()) * 1.1
    depth = int(np.clip(np.round(np.log2(side / cell_m)), 5, 10))
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points.astype(float), v_normals_matrix=normals.astype(float)))
    meshes.generate_surface_reconstruction_screened_poisson(
        depth=depth, pointweight=4.0, samplespernode=1.5, threads=1, preclean=False
    )
    mesh = meshes.current_mesh()
    return Shape(vertices_m=mesh.vertex_matrix().copy(), faces=mesh.face_matrix().astype(np.int32))


def cut_open(
    surface: Shape, points: np.ndarray, openings: int, reach_m: float, edge_m: float
) -> tuple[Shape, list[float]]:
    """Cut the garment's openings into a Poisson surface.

    Poisson closes everything. Patches farther than `reach_m` from any point are either an opening of the garment or a hole of
    the scan (occlusion, drop-out). The `openings` patches with the longest rims are openings: they are removed, back to where
    the surface comes within `edge_m` of a point. The others stay closed.

    Args:
        surface: of `poisson`.
        points: (n, 3) m.
        openings: boundary loops of the real garment.
        reach_m: largest gap between points that is not a hole.
        edge_m: how far the surface reaches beyond the outermost points.

    Returns:
        The open surface (its largest piece); rim lengths (m) of all patches found, longest first.

    Raises:
        BadInput: fewer patches than openings.
    """
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(points).query(surface.vertices_m)
    far = distance[surface.faces].max(axis=1)
    label, rims = _patches(surface, far > reach_m)
    order = np.argsort(-rims, kind="stable")
    lengths = [float(rims[index]) for index in order]
    if len(order) < openings:
        raise BadInput(
            f"the surface of the scan has {len(order)} gaps, but the garment file says openings: {openings};"
            " correct it, or scan the edges of the garment (Poisson closes what the points surround on all sides)"
        )
    wide, _ = _patches(surface, far > edge_m)
    opened = np.isin(wide, np.unique(wide[np.isin(label, order[:openings])])) & (wide >= 0)
    value = np.full(len(distance), edge_m)
    touched = np.unique(surface.faces[opened])
    value[touched] -= distance[touched]
    return clip(surface, value), lengths


def _patches(surface: Shape, among: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Component labels of the faces of `among`, and the length of each component's longest rim (m)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from trimesh.graph import face_adjacency

    label = face_components(surface.faces, among)
    pairs, edges = face_adjacency(surface.faces, return_edges=True)
    rim = among[pairs[:, 0]] != among[pairs[:, 1]]
    inside = label[np.where(among[pairs[rim, 0]], pairs[rim, 0], pairs[rim, 1])]
    length = np.linalg.norm(np.diff(surface.vertices_m[edges[rim]], axis=1)[:, 0], axis=1)
    longest = np.zeros(label.max() + 1)
    if rim.any():
        # A corner of the rim counts once for each patch at it: patches that touch there have rims of their own.
        ends = np.stack([np.repeat(inside, 2), edges[rim].ravel()], axis=1)
        corners, place = np.unique(ends, axis=0, return_inverse=True)
        first, last = place.reshape(-1, 2).T
        graph = coo_matrix((np.ones(len(first)), (first, last)), shape=(len(corners),) * 2)
        _, loop = connected_components(graph, directed=False)
        np.maximum.at(longest, inside, np.bincount(loop[first], length)[loop[first]])
    return label, longest
