"""Whether a garment was folded as the task asks, in numbers."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from PIL import Image, ImageDraw

from sim1.robot.expert_task import Limits, Task, find_keypoints, ideal_fold
from sim1.validity.penetration import crossings

type Failure = Literal[
    "unreachable",
    "missed grasp",
    "slip",
    "over-stretch",
    "penetration",
    "not folded",
    "simulation broke",
    "off the table",
]
# Runs that were not carried out to their end, or not as they were asked for. They fail whatever the garment looks like
# by then, often well folded with an arm that does not find home: to filters that look at the garment alone, they would be
# folded garments called failures.
CUT_SHORT = frozenset({"unreachable", "too fast", "beyond joint limits", "no source motion", "simulation broke"})
OUT_OF_VIEW = "out of view"  # of the head camera, which is no matter of how the garment is folded
PIXEL_M = 0.004
LAST_FRAMES = 10  # a third of a second
_TINY = 1e-12  # a limit of nothing has no shares
LOOKED_AT = 8  # frames in which layers are looked at for having gone through each other, the last one among them


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """Outcome of one run."""

    success: bool
    figures: dict[str, float]
    failure: Failure | None


def judge(garment_m: np.ndarray, faces: np.ndarray, task: Task) -> Judgement:
    """Judge a run from its garment trajectory.

    Args:
        garment_m: (T, v, 3), world frame, table top at z = 0; the first frame lies flat, before anything moved.
        faces: (f, 3).
        task: folds and limits.
    """
    if not np.isfinite(garment_m).all():
        return Judgement(success=False, figures={}, failure="simulation broke")
    start, end = garment_m[0].astype(float), garment_m[-1].astype(float)
    ideal = ideal_fold(start, task)
    marks = find_keypoints(start, task)
    grasped = sorted({marks[move.grasp] for step in task.steps for move in (step.left, step.right)})
    low = np.minimum(start[:, :2].min(axis=0), ideal.min(axis=0)) - 0.3
    high = np.maximum(start[:, :2].max(axis=0), ideal.max(axis=0)) + 0.3
    first, last, wanted = (silhouette(points, faces, low, high) for points in (start, end, ideal))
    before = garment_m[-min(LAST_FRAMES, len(garment_m))].astype(float)
    duration = max(min(LAST_FRAMES, len(garment_m)) - 1, 1) / 30.0
    errors = np.linalg.norm(end[grasped, :2] - ideal[grasped], axis=1)
    figures = {
        "iou": float((last & wanted).sum() / max((last | wanted).sum(), 1)),
        "keypoint_error_m": float(errors.max()),
        "area_ratio": float(last.sum() / max(first.sum(), 1)),
        "ideal_area_ratio": float(wanted.sum() / max(first.sum(), 1)),
        "height_m": float(end[:, 2].max()),
        "speed_m_s": float(np.percentile(np.linalg.norm(end - before, axis=1), 99) / duration),
        "lowest_m": float(end[:, 2].min()),
        "face_down_share": _face_down_share(start, end, faces),
        "stretch": _stretch(garment_m, faces),
        "crossing_count": _crossings(garment_m, faces),
        "lifted_m": float((garment_m[:, grasped, 2].max(axis=0) - start[grasped, 2]).min()),
    }
    failure = _failure(figures, garment_m, ideal, grasped, task)
    return Judgement(success=failure is None, figures=figures, failure=failure)


def silhouette(points: np.ndarray, faces: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Covered pixels of the table between the corners `low` and `high` (2,), as bool (ny, nx), `PIXEL_M` each."""
    size = np.ceil((high - low) / PIXEL_M).astype(int)
    image = Image.new("1", (int(size[0]), int(size[1])))
    draw = ImageDraw.Draw(image)
    for corners in ((points[:, :2] - low) / PIXEL_M)[faces]:
        draw.polygon([tuple(corner) for corner in corners.tolist()], fill=1)
    return np.asarray(image)


def _face_down_share(start: np.ndarray, end: np.ndarray, faces: np.ndarray) -> float:
    """Share of the area at the start whose upper side has come to look down."""
    before, after = (np.cross(m[faces[:, 1]] - m[faces[:, 0]], m[faces[:, 2]] - m[faces[:, 0]]) for m in (start, end))
    area = np.linalg.norm(before, axis=1)
    return float(area[before[:, 2] * after[:, 2] < 0].sum() / max(area.sum(), 1e-12))


def _crossings(garment_m: np.ndarray, faces: np.ndarray) -> float:
    """Most edges at a time that pass through a face."""
    frames = np.linspace(0, len(garment_m) - 1, LOOKED_AT + 1).round().astype(int)[1:]
    return float(max(len(crossings(garment_m[frame].astype(float), faces)) for frame in frames))


def _stretch(garment_m: np.ndarray, faces: np.ndarray) -> float:
    """Largest over time of the 99th percentile over edges of length now over length at the start."""
    a, b = faces[:, [0, 1, 2]].ravel(), faces[:, [1, 2, 0]].ravel()
    rest = np.maximum(np.linalg.norm(garment_m[0, a] - garment_m[0, b], axis=1), 1e-6)
    sample = garment_m[:: max(1, len(garment_m) // 60)]
    return max(float(np.percentile(np.linalg.norm(frame[a] - frame[b], axis=1) / rest, 99)) for frame in sample)


def _failure(
    figures: dict[str, float], garment_m: np.ndarray, ideal: np.ndarray, grasped: list[int], task: Task
) -> Failure | None:
    limits = task.success
    if figures["lowest_m"] < -0.02:
        return "off the table"
    if figures["stretch"] > limits.stretch:
        return "over-stretch"
    if figures["crossing_count"] > 0:
        return "penetration"
    if fold_excess(figures, limits) <= 0:
        return None
    if figures["lifted_m"] < limits.lifted_m:
        return "missed grasp"
    return "slip" if _fell_early(garment_m, ideal, grasped, limits.lifted_m) else "not folded"


def fold_excess(figures: Mapping[str, float], limits: Limits) -> float:
    """How far the worst figure of the fold lies beyond its limit, as a share of that limit; up to 0 it is folded."""
    highest = {name: getattr(limits, name) for name in ("keypoint_error_m", "height_m", "speed_m_s")}
    highest["area_ratio"] = figures["ideal_area_ratio"] + limits.area_excess
    lowest = {name: getattr(limits, name) for name in ("iou", "face_down_share")}
    beyond = [(figures[name] - limit) / max(limit, _TINY) for name, limit in highest.items()]
    beyond += [(limit - figures[name]) / max(limit, _TINY) for name, limit in lowest.items()]
    return float(np.max(beyond))  # NaN where a figure is NaN: NaN <= 0 is false


def _fell_early(garment_m: np.ndarray, ideal: np.ndarray, grasped: list[int], lifted_m: float) -> bool:
    """A grasped point came down for good less than half of the way to its place."""
    for vertex in grasped:
        path = garment_m[:, vertex]
        up = np.flatnonzero(path[:, 2] > lifted_m)
        if len(up) == 0:
            return True
        where = path[up[-1], :2]
        way = np.linalg.norm(ideal[vertex] - path[0, :2])
        if np.linalg.norm(where - ideal[vertex]) > 0.5 * way:
            return True
    return False
