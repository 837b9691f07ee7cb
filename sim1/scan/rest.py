"""The stress-free shape of a garment: flat where it can be laid flat without stretching, the scanned shape otherwise."""

from dataclasses import dataclass

import numpy as np

from sim1.scan.rims import rim_lengths_m

_STRETCH_LIMIT = 0.005  # RMS relative change of an edge; a woven fabric takes more without resistance


@dataclass(frozen=True, kw_only=True)
class Rest:
    """Rest shape and why it was chosen."""

    rest_m: np.ndarray  # (v, 3)
    flat: bool
    stretch_rms: float | None  # relative change of edge length of the best flat shape, None where there is none


def rest_shape(vertices_m: np.ndarray, faces: np.ndarray) -> Rest:
    """Rest shape of a scanned mesh.

    A sheet with one rim is laid flat, by least squares of its edge lengths. If that changes them by at most 0.5 % RMS, the
    garment is developable and the flat shape is its rest shape. Otherwise (a garment sewn in three dimensions, worn on a
    mannequin) the scan does not show how much the fabric was stretched, and the scanned shape itself is taken.
    """
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    euler = len(vertices_m) - len(edges) + len(faces)
    if euler != 1 or len(rim_lengths_m(vertices_m, faces)) != 1:
        return Rest(rest_m=vertices_m.copy(), flat=False, stretch_rms=None)
    middle = vertices_m.mean(axis=0)
    _, _, axes = np.linalg.svd(vertices_m - middle, full_matrices=False)
    if _outward(vertices_m, faces) @ np.cross(axes[0], axes[1]) < 0:
        axes[1] = -axes[1]  # the flat shape shows the same side as the scan
    flat, stretch = _flatten(
        (vertices_m - middle) @ axes[:2].T,
        edges,
        np.linalg.norm(vertices_m[edges[:, 0]] - vertices_m[edges[:, 1]], axis=1),
    )
    rms = float(np.sqrt((stretch**2).mean()))
    if rms > _STRETCH_LIMIT:
        return Rest(rest_m=vertices_m.copy(), flat=False, stretch_rms=rms)
    return Rest(rest_m=middle + flat @ axes[:2], flat=True, stretch_rms=rms)


def _outward(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    corners = vertices[faces]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)


def _flatten(start: np.ndarray, edges: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Plane positions (v, 2) whose edges have the given lengths as nearly as possible, and what is left of the differences."""
    from scipy.optimize import least_squares
    from scipy.sparse import coo_matrix

    rows = np.repeat(np.arange(len(edges)), 2)

    def residual(flat: np.ndarray) -> np.ndarray:
        flat = flat.reshape(-1, 2)
        return np.linalg.norm(flat[edges[:, 0]] - flat[edges[:, 1]], axis=1) / length - 1.0

    def jacobian(flat: np.ndarray) -> coo_matrix:
        flat = flat.reshape(-1, 2)
        difference = flat[edges[:, 0]] - flat[edges[:, 1]]
        slope = difference / (np.linalg.norm(difference, axis=1) * length)[:, None]
        columns = [2 * edges[:, [k]] + [0, 1] for k in (0, 1)]
        values = np.concatenate([slope.ravel(), -slope.ravel()])
        place = np.concatenate([rows, rows]), np.concatenate([columns[0].ravel(), columns[1].ravel()])
        return coo_matrix((values, place), shape=(len(edges), flat.size)).tocsr()

    found = least_squares(residual, start.ravel(), jacobian, method="trf", tr_solver="lsmr", max_nfev=60)
    return found.x.reshape(-1, 2), found.fun
