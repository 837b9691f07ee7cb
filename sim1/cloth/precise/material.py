"""A bundle's mesh and markers in material coordinates."""

import numpy as np

from sim1.cloth.precise.mesh import Sheet, place_on
from sim1.recording.bundle import Bundle
from sim1.recording.mesh import RestMesh
from sim1.stage import BadInput

FLAT = 1e-3  # thickness over length of a mesh that needs no material coordinates


def sheet_of(bundle: Bundle) -> Sheet:
    """The bundle's rest mesh as a flat sheet.

    Raises:
        BadInput: the mesh has no material coordinates and is not flat, or a face without area or turned over in them.
    """
    material = bundle.mesh.material_m
    if material is None:
        middle = bundle.mesh.vertices_m.mean(0)
        _, size, axes = np.linalg.svd(bundle.mesh.vertices_m - middle, full_matrices=False)
        if size[2] > FLAT * size[0]:
            raise BadInput(
                f"{bundle.mesh.path}: no material coordinates (`vt`) on a mesh that is not flat, but {size[2] / size[0]:.2g} times as thick as "
                "it is long; write them in metres"
            )
        material = bundle.mesh.vertices_m @ _threads(axes[2], bundle.mesh).T
    sheet = Sheet(material_m=material, faces=bundle.mesh.faces, source=str(bundle.mesh.path))
    _ = sheet.face_area_m2  # asked here, where faces are counted as in the file: later they are cut and reordered
    return sheet


def _threads(normal: np.ndarray, mesh: RestMesh) -> np.ndarray:
    """Directions (2, 3) of u and v in a flat mesh that says nothing of them: of its own axes the first that lies flattest in it, and across, as faces turn."""
    a, b, c = (mesh.vertices_m[mesh.faces[:, k]] for k in range(3))
    if np.cross(b - a, c - a).sum(0) @ normal < 0.0:
        normal = -normal
    axis = np.eye(3)[int(np.argmin(np.abs(normal).round(6)))]
    u = axis - (axis @ normal) * normal
    u /= np.linalg.norm(u)
    return np.stack([u, np.cross(normal, u)])


def marker_points(bundle: Bundle) -> np.ndarray:
    """Material coordinates (M, 2) of the markers."""
    sheet = sheet_of(bundle)
    return (sheet.material_m[sheet.faces[bundle.anchors.face]] * bundle.anchors.weight[..., None]).sum(1)


def markers_on(bundle: Bundle, sheet: Sheet, points_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Face (M,) and barycentric coordinates (M, 3) of the markers, at `points_m` (M, 2), on the bundle's sheet, however it was cut and reordered.

    Raises:
        BadInput: a marker that no face near it holds.
    """
    path = bundle.folder / "anchors.parquet"
    return place_on(sheet, points_m, [f"{path}: marker {marker}" for marker in bundle.anchors.marker])
