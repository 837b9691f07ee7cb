"""From a dense surface to a small mesh of even triangles for the simulation."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.pieces import largest_piece
from sim1.scan.rims import inset, rim_overshoot_m, smooth_rims


def clean(surface: Shape, points: np.ndarray, spacing_m: float, taubin_steps: int) -> Shape:
    """Non-manifold parts repaired, rims put where the fabric ends, all smoothed without shrinking (Taubin 1995)."""
    import pymeshlab

    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(surface.vertices_m.astype(float), surface.faces))
    meshes.meshing_repair_non_manifold_edges(method="Remove Faces")
    meshes.meshing_repair_non_manifold_vertices(vertdispratio=0)
    mesh = meshes.current_mesh()
    piece = largest_piece(mesh.vertex_matrix(), mesh.face_matrix())
    piece = Shape(vertices_m=smooth_rims(piece), faces=piece.faces)
    piece = inset(piece, rim_overshoot_m(piece, points, spacing_m))
    piece = Shape(vertices_m=smooth_rims(piece), faces=piece.faces)
    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.add_mesh(pymeshlab.Mesh(piece.vertices_m, piece.faces))
    if taubin_steps:
        meshes.apply_coord_taubin_smoothing(lambda_=0.5, mu=-0.53, stepsmoothnum=taubin_steps)
    mesh = meshes.current_mesh()
    return Shape(vertices_m=mesh.vertex_matrix().copy(), faces=mesh.face_matrix().astype(np.int32))


def remesh(surface: Shape, edge_m: float, rounds: int = 10) -> Shape:
    """Isotropic remeshing (Botsch & Kobbelt 2004) to edges of about `edge_m`, of a decimated copy.

    Whether decimating first pays depends on the surface: `make bench` shows the ratio.
    """
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
