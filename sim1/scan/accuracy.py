"""How far a mesh lies from the scan points and, for virtual scans, from the truth."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.surface import closest_points

_SAMPLES = 40_000


def errors_mm(distance_m: np.ndarray) -> dict[str, float]:
    """Root mean square, 95th percentile and maximum of distances, mm."""
    distance = np.abs(distance_m) * 1e3
    figures = np.sqrt((distance**2).mean()), np.percentile(distance, 95), distance.max()
    return dict(zip(("rms_mm", "p95_mm", "max_mm"), (round(float(value), 4) for value in figures), strict=True))


def deviations(
    mesh: Shape, points: np.ndarray, normals: np.ndarray, truth: Shape | None, rng: np.random.Generator
) -> tuple[dict[str, dict[str, float]], np.ndarray]:
    """All errors of a mesh, and the distance (n,) m of every point to it.

    `mesh_to_points` is measured along the normal of the nearest point: the plain distance to a cloud would measure the
    cloud's spacing. Where the mesh closes a hole of the scan it extrapolates those planes.

    Args:
        mesh: the mesh to judge.
        points, normals: (n, 3) scan points of the garment.
        truth: of a virtual scan; the direction truth to mesh includes what no view has seen.
        rng: of the samples on the surfaces.
    """
    from scipy.spatial import cKDTree

    _, _, distance = closest_points(points, mesh.vertices_m, mesh.faces)
    samples = samples_on(mesh, _SAMPLES, rng)
    _, near = cKDTree(points).query(samples)
    result = {
        "points_to_mesh": errors_mm(distance),
        "mesh_to_points": errors_mm(((samples - points[near]) * normals[near]).sum(axis=1)),
    }
    if truth is not None:
        result["mesh_to_truth"] = errors_mm(closest_points(samples, truth.vertices_m, truth.faces)[2])
        result["truth_to_mesh"] = errors_mm(
            closest_points(samples_on(truth, _SAMPLES, rng), mesh.vertices_m, mesh.faces)[2]
        )
    return result, distance


def samples_on(mesh: Shape, count: int, rng: np.random.Generator) -> np.ndarray:
    """Points (count, 3) evenly spread over the area of a mesh."""
    corners = mesh.vertices_m[mesh.faces].astype(float)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    face = rng.choice(len(corners), count, p=area / area.sum())
    return np.einsum("nk,nkd->nd", rng.dirichlet((1.0, 1.0, 1.0), count), corners[face])
