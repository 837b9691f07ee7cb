"""From a dense surface to a small mesh of even triangles for the simulation."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.poisson import largest_piece


def clean(surface: Shape, taubin_steps: int) -> Shape:
    """Non-manifold parts repaired, rims and surface smoothed without shrinking (Taubin 1995)."""
    import pymeshlab

    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices_m.astype(float), surface.faces))
    meshes.meshing_repair_non_manifold_edges(method="Remove Faces")
    meshes.meshing_repair_non_manifold_vertices(vertdispratio=0)
    mesh = meshes.current_mesh()
    piece = largest_piece(mesh.vertex_matrix(), mesh.face_matrix())
    piece = Shape(vertices_m=smooth_rims(piece), faces=piece.faces)
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(piece.vertices_m, piece.faces))
    if taubin_steps:
        meshes.apply_coord_taubin_smoothing(lambda_=0.5, mu=-0.53, stepsmoothnum=taubin_steps)
    mesh = meshes.current_mesh()
    return Shape(vertices_m=mesh.vertex_matrix().copy(), faces=mesh.face_matrix().astype(np.int32))


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


def rim_edges(faces: np.ndarray) -> np.ndarray:
    """Edges of one face only, in the direction of that face: (e, 2)."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key = np.sort(edges, axis=1)
    _, index, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    return edges[count[index.ravel()] == 1]


def remesh(surface: Shape, edge_m: float, rounds: int = 10) -> Shape:
    """Isotropic remeshing (Botsch & Kobbelt 2004) to edges of about `edge_m`, of a decimated copy, which is five times faster."""
    import pymeshlab

    dense = area_m2(surface.vertices_m, surface.faces) / (0.433 * (edge_m / 4) ** 2)
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices_m.astype(float), surface.faces))
    if dense < len(surface.faces):
        meshes.meshing_decimation_quadric_edge_collapse(
            targetfacenum=int(dense), preserveboundary=True, boundaryweight=2.0, preservenormal=True, preservetopology=True,
            planarquadric=True,
        )  # fmt: skip
    meshes.meshing_isotropic_explicit_remeshing(
        iterations=rounds, targetlen=pymeshlab.PureValue(edge_m), featuredeg=180.0
    )
    mesh = meshes.current_mesh()
    return largest_piece(mesh.vertex_matrix().copy(), mesh.face_matrix())


def area_m2(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Area of a mesh."""
    corners = vertices[faces]
    return float(
        np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
    )


def corner_angles_rad(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Angles (f, 3) of the triangles."""
    corners = vertices[faces]
    result = []
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        result.append(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)))
    return np.stack(result, axis=1)


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
