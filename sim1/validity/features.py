"""Readable figures of what a garment did in an episode, phase by phase, for rules that a person can check."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sim1.episode import RATE_HZ
from sim1.motion.placement import unplaced
from sim1.validity.penetration import crossings
from sim1.validity.raster import Camera, render

PHASES = ("early", "middle", "late", "end")  # thirds of the time, and the last frame
FRAMES_PER_PHASE = 5  # looked at within a third; the garment changes little in between
FAR_M = 60.0  # a camera this high sees the table without perspective
PIXEL_M = 0.005  # resolution of the covered area
SPEED_FRAMES = 5  # end speed is the mean over this many frames


@dataclass(frozen=True, kw_only=True)
class Reference:
    """What the features of a garment's episodes are measured against."""

    faces: np.ndarray  # (f, 3)
    edges: np.ndarray  # (e, 2)
    rest_length_m: np.ndarray  # (e,)
    rest_area_m2: float
    start_m: np.ndarray  # (v, 3) settled on the table, not moved
    keypoints: Mapping[str, int]  # name -> vertex


def episode_features(garment_m: np.ndarray, reference: Reference) -> dict[str, float]:
    """Figures of a garment (T, v, 3) over an episode, by name `phase.figure`; units stand in the names.

    Covered area is a share of the garment's rest area, stretch a ratio to rest length, distances between keypoints a share of
    that distance at the start. All are taken as if the garment had been laid down at the reference's start.
    """
    garment_m = unplaced(garment_m, reference.start_m)
    result: dict[str, float] = {}
    start = distances(garment_m[0], reference)
    for phase, frames in _frames(len(garment_m)).items():
        states = [_state(garment_m[frame].astype(float), reference) for frame in frames]
        for name in states[0]:
            values = [state[name] for state in states]
            result[f"{phase}.{name}"] = float(min(values) if name == "covered_share" else max(values))
        here = distances(garment_m[frames[-1]].astype(float), reference)
        for pair, distance in here.items():
            result[f"{phase}.distance_share.{pair}"] = distance / max(start[pair], 1e-6)
    tail = garment_m[-min(SPEED_FRAMES + 1, len(garment_m)) :].astype(float)
    speeds = np.linalg.norm(tail[-1] - tail[0], axis=-1) * RATE_HZ / max(len(tail) - 1, 1)
    result["end.crossing_count"] = float(len(crossings(tail[-1], reference.faces)))
    result["end.speed_m_s"] = float(np.quantile(speeds, 0.99))
    return result


def distances(garment_m: np.ndarray, reference: Reference) -> dict[str, float]:
    """Distance [m] of every pair of keypoints, by `one-other`."""
    names = sorted(reference.keypoints)
    points = {name: garment_m[reference.keypoints[name]] for name in names}
    return {
        f"{one}-{other}": float(np.linalg.norm(points[one] - points[other]))
        for index, one in enumerate(names)
        for other in names[index + 1 :]
    }


def covered_area_m2(garment_m: np.ndarray, faces: np.ndarray) -> float:
    """Area that the garment (v, 3) covers seen from above [m^2]."""
    low, high = garment_m[:, :2].min(axis=0), garment_m[:, :2].max(axis=0)
    size = np.ceil((high - low) / PIXEL_M).astype(int) + 2
    pose = np.eye(4)
    pose[:3, 3] = [*((low + high) / 2), FAR_M]
    camera = Camera(camera_to_world=pose, fy_px=FAR_M / PIXEL_M, width=int(size[0]), height=int(size[1]))
    canvas = np.zeros((camera.height, camera.width, 3))
    depth = np.full(canvas.shape[:2], np.inf)
    render(garment_m, faces, np.ones(3), camera, canvas, depth)
    return float(np.isfinite(depth).sum() * PIXEL_M**2)


def _frames(count: int) -> dict[str, list[int]]:
    bounds = np.linspace(0, count - 1, len(PHASES))
    frames = {
        phase: sorted(set(np.linspace(low, high, FRAMES_PER_PHASE).round().astype(int).tolist()))
        for phase, low, high in zip(PHASES[:-1], bounds[:-1], bounds[1:], strict=True)
    }
    return frames | {PHASES[-1]: [count - 1]}


def _state(garment_m: np.ndarray, reference: Reference) -> dict[str, float]:
    """Figures of one moment."""
    extent = np.sort(np.ptp(garment_m[:, :2], axis=0))
    edges = garment_m[reference.edges]
    stretch = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=-1) / reference.rest_length_m
    return {
        "covered_share": covered_area_m2(garment_m, reference.faces) / reference.rest_area_m2,
        "height_p99_m": float(np.quantile(garment_m[:, 2], 0.99)),
        "height_p50_m": float(np.median(garment_m[:, 2])),
        "extent_long_m": float(extent[1]),
        "extent_short_m": float(extent[0]),
        "stretch_p50": float(np.median(stretch)),
        "stretch_p95": float(np.quantile(stretch, 0.95)),
        "stretch_p99": float(np.quantile(stretch, 0.99)),
    }
