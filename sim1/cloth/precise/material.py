"""A bundle's mesh and markers in material coordinates."""

import numpy as np

from sim1.cloth.precise.mesh import Sheet
from sim1.recording.bundle import Bundle
from sim1.stage import BadInput


def sheet_of(bundle: Bundle) -> Sheet:
    """The bundle's rest mesh as a flat sheet.

    Raises:
        BadInput: the mesh has no material coordinates and is not flat.
    """
    if bundle.mesh.material_m is not None:
        return Sheet(material_m=bundle.mesh.material_m, faces=bundle.mesh.faces)
    middle = bundle.mesh.vertices_m.mean(0)
    _, size, axes = np.linalg.svd(bundle.mesh.vertices_m - middle, full_matrices=False)
    if size[2] > 1e-3 * size[0]:
        raise BadInput("garment.obj: no material coordinates on a mesh that is not flat; write them as `vt` in metres")
    return Sheet(material_m=(bundle.mesh.vertices_m - middle) @ axes[:2].T, faces=bundle.mesh.faces)


def marker_points(bundle: Bundle) -> np.ndarray:
    """Material coordinates (M, 2) of the markers."""
    sheet = sheet_of(bundle)
    return (sheet.material_m[sheet.faces[bundle.anchors.face]] * bundle.anchors.weight[..., None]).sum(1)
