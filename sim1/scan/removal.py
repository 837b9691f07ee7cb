"""Which points of a scan are the garment's: everything that is not the support (mannequin, rack)."""

from dataclasses import dataclass

import numpy as np

from sim1.scan.cloud import Cloud, Shape

_NEIGHBOURS = 10
_COLOR_BINS = 8  # per channel
_SURE_GARMENT_M = 0.004  # farther from the registered support than its residual error could explain
_SURE_SUPPORT_M = 0.0008  # nearer than the thickness of a fabric


@dataclass(frozen=True, kw_only=True)
class Separation:
    """The garment's points and how they were found."""

    garment: np.ndarray  # (n,) bool
    method: str
    support_to_world: np.ndarray | None = None  # (4, 4) found by registration
    support_rms_m: float | None = None  # residual of the points taken for the support


def separate(cloud: Cloud, support: Shape | None, mask: np.ndarray | None) -> Separation:
    """Tell the garment from its support.

    A manual mask is obeyed. With a support mesh: registration, then distance and colour, then a vote of neighbours.
    Without either every point is the garment's. Last, stray clusters are dropped (but not under a mask).
    """
    if mask is not None:
        return Separation(garment=mask, method="manual mask")
    if support is None:
        return Separation(garment=main_component(cloud.points_m, np.ones(len(cloud), bool)), method="no support given")
    pose, distance = register(cloud.points_m.astype(float), support)
    garment = _classify(distance, cloud.colors)
    garment = _vote(cloud.points_m, garment)
    near = ~garment & (np.abs(distance) < _SURE_GARMENT_M)
    return Separation(
        garment=main_component(cloud.points_m, garment),
        method="registered support",
        support_to_world=pose,
        support_rms_m=float(np.sqrt((distance[near] ** 2).mean())) if near.any() else None,
    )


def register(points: np.ndarray, support: Shape, rounds: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Rigid pose of the support in the scan, by ICP, point to plane.

    Most of a dressed mannequin is hidden, so garment points must not pull at it: Geman-McClure weights with a width that
    shrinks from 10 mm to 0.5 mm in front of the support, and stays wide behind its surface, where no point can lie.

    Args:
        points: (n, 3) m.
        support: closed mesh, some centimetres and degrees off at most.

    Returns:
        Pose (4, 4); signed distance (n,) m of each point to the support at that pose, positive outside.
    """
    from scipy.spatial.transform import Rotation

    from sim1.scan.surface import closest_points

    vertices, faces = support.vertices_m.astype(float), support.faces
    corners = vertices[faces]
    face_normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    face_normals /= np.maximum(np.linalg.norm(face_normals, axis=1, keepdims=True), 1e-20)
    sample = points[:: max(1, len(points) // 20_000)]
    pose = np.eye(4)  # world to support
    for width in np.geomspace(0.010, 0.0005, rounds):
        local = sample @ pose[:3, :3].T + pose[:3, 3]
        closest, face, _ = closest_points(local, vertices, faces)
        normal = face_normals[face]
        gap = ((local - closest) * normal).sum(axis=1)
        scale = np.where(gap > 0, width, 0.010)  # no point can lie inside the support: those in front give way
        weight = (scale**2 / (scale**2 + gap**2)) ** 2
        middle = local.mean(axis=0)
        rows = np.concatenate([np.cross(local - middle, normal), normal], axis=1) * np.sqrt(weight)[:, None]
        step = np.linalg.lstsq(rows, -gap * np.sqrt(weight), rcond=1e-6)[0]
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(step[:3]).as_matrix()
        turn[:3, 3] = middle - turn[:3, :3] @ middle + step[3:]
        pose = turn @ pose
    local = points @ pose[:3, :3].T + pose[:3, 3]
    closest, face, distance = closest_points(local, vertices, faces)
    sign = np.sign(((local - closest) * face_normals[face]).sum(axis=1))
    return np.linalg.inv(pose), distance * np.where(sign == 0, 1.0, sign)


def _classify(distance: np.ndarray, colors: np.ndarray) -> np.ndarray:
    """Naive Bayes of distance and colour; the colours of both classes are learned where the distance alone is sure."""
    bins = (colors.astype(int) * _COLOR_BINS // 256) @ [_COLOR_BINS**2, _COLOR_BINS, 1]
    sure = distance > _SURE_GARMENT_M, np.abs(distance) < _SURE_SUPPORT_M
    counts = [np.bincount(bins[which], minlength=_COLOR_BINS**3) + 0.5 for which in sure]
    color = np.log(counts[0] / counts[0].sum()) - np.log(counts[1] / counts[1].sum())
    # Log odds of the distance: 0 half-way between the two sure limits, 5 (a hundred to one) at either.
    middle, half = (_SURE_GARMENT_M + _SURE_SUPPORT_M) / 2, (_SURE_GARMENT_M - _SURE_SUPPORT_M) / 2
    place = 5.0 * (distance - middle) / half
    return np.where(np.abs(distance) > 3 * _SURE_GARMENT_M, distance > 0, place + np.clip(color[bins], -6.0, 6.0) > 0)


def _vote(points: np.ndarray, garment: np.ndarray, rounds: int = 3) -> np.ndarray:
    from scipy.spatial import cKDTree

    _, near = cKDTree(points).query(points, k=_NEIGHBOURS)
    for _ in range(rounds):
        garment = garment[near].mean(axis=1) > 0.5
    return garment


def main_component(points: np.ndarray, keep: np.ndarray, least: float = 0.05) -> np.ndarray:
    """Of the kept points, those in clusters with at least the share `least` of them; clusters lie five spacings apart."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    chosen = np.flatnonzero(keep)
    if not len(chosen):
        return keep
    distance, near = cKDTree(points[chosen]).query(points[chosen], k=min(_NEIGHBOURS, len(chosen)))
    linked = distance < 5 * np.median(distance[:, min(4, distance.shape[1] - 1)])
    rows = np.repeat(np.arange(len(chosen)), near.shape[1]).reshape(near.shape)
    graph = coo_matrix((np.ones(linked.sum()), (rows[linked], near[linked])), shape=(len(chosen),) * 2)
    _, label = connected_components(graph, directed=False)
    big = np.bincount(label) >= least * len(chosen)
    result = np.zeros_like(keep)
    result[chosen[big[label]]] = True
    return result
