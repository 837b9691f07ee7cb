"""The cloth around each marker as a small flat piece: where its neighbours went gives normal, stretch and curvature."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sim1.recording.bundle import Bundle

NEIGHBOURS = 8
FLATTEST = 0.05  # of the neighbours' shape: below, they lie on a line and say nothing across it


@dataclass(frozen=True, kw_only=True)
class SheetFit:
    """Cloth around each of M markers at T frames; NaN where too few neighbours were seen."""

    gradient: np.ndarray  # (T, M, 3, 2) change of place over material coordinates
    normal: np.ndarray  # (T, M, 3) unit, u x v
    curvature_1_m: np.ndarray  # (T, M, 2) along u and along v
    spacing_m: float  # from a marker to its neighbours, median


def material_of_markers(bundle: Bundle) -> np.ndarray | None:
    """Where each marker sits on the flat cloth, (M, 2); None where the mesh is neither flat nor has material coordinates."""
    mesh, flat = bundle.mesh, bundle.mesh.material_m
    if flat is None:
        centred = mesh.vertices_m - mesh.vertices_m.mean(0)
        _, extent, axes = np.linalg.svd(centred, full_matrices=False)
        if extent[2] > 0.01 * extent[0]:
            return None
        flat = centred @ axes[:2].T
    return (flat[mesh.faces[bundle.anchors.face]] * bundle.anchors.weight[..., None]).sum(1)


def fit_sheet(material_m: np.ndarray, markers_m: np.ndarray) -> SheetFit | None:
    """Fit the cloth around markers at material coordinates (M, 2) and places (T, M, 3); None with fewer than 4 markers."""
    if len(material_m) < 4:
        return None
    far, near = cKDTree(material_m).query(material_m, k=min(NEIGHBOURS, len(material_m) - 1) + 1)
    near = near[:, 1:]
    offset = material_m[near] - material_m[:, None]  # (M, k, 2)
    gradient = _slope(offset, markers_m[:, near] - markers_m[:, :, None])
    normal = np.cross(gradient[..., 0], gradient[..., 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    turning = _slope(offset, normal[:, near] - normal[:, :, None])
    curvature = -(turning * gradient).sum(2) / np.maximum((gradient**2).sum(2), 0.25)
    return SheetFit(gradient=gradient, normal=normal, curvature_1_m=curvature, spacing_m=float(np.median(far[:, 1:])))


def _slope(offset_m: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Least-squares derivative (T, M, 3, 2) of changes (T, M, k, 3) over offsets (M, k, 2); NaN where undetermined."""
    seen = np.isfinite(change).all(-1).astype(float)
    change = np.where(seen[..., None] > 0, change, 0.0)
    square = np.einsum("tmk,mkij->tmij", seen, offset_m[..., :, None] * offset_m[..., None, :])
    mixed = np.einsum("tmkc,mki->tmci", change, offset_m)
    determinant = square[..., 0, 0] * square[..., 1, 1] - square[..., 0, 1] ** 2
    trace = square[..., 0, 0] + square[..., 1, 1]
    good = determinant > FLATTEST * np.maximum(trace, 1e-12) ** 2 / 4
    inverse = np.empty_like(square)
    inverse[..., 0, 0], inverse[..., 1, 1] = square[..., 1, 1], square[..., 0, 0]
    inverse[..., 0, 1] = inverse[..., 1, 0] = -square[..., 0, 1]
    found = np.matmul(mixed, inverse) / np.where(good, determinant, 1.0)[..., None, None]
    found[~good] = np.nan
    return found
