"""Pictures of a demonstration for people."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from sim1.episode import RATE_HZ, Episode
from sim1.picture_file import save_figure
from sim1.robot.expert_task import Task, ideal_fold

FRONT, BACK = np.array([0.27, 0.47, 0.75]), np.array([0.82, 0.62, 0.35])


def film_strip(path: Path, episode: Episode, faces: np.ndarray, *, title: str, count: int = 8) -> None:
    """Top and side view of the garment at evenly spaced times."""
    figure = Figure(figsize=(2.0 * count, 4.6), layout="constrained")
    axes = figure.subplots(2, count, sharex="row", sharey="row", height_ratios=[2.2, 1])
    reach = float(np.abs(episode.garment_m[::10, :, :2]).max()) + 0.03
    top = max(0.12, float(episode.garment_m[::10, :, 2].max())) + 0.02
    for column, frame in enumerate(np.linspace(0, episode.frame_count - 1, count).astype(int)):
        points = episode.garment_m[frame].astype(float)
        _draw(axes[0, column], points, faces, right=-points[:, 1], up=points[:, 0], depth=points[:, 2])
        _draw(axes[1, column], points, faces, right=points[:, 0], up=points[:, 2], depth=-points[:, 1])
        axes[0, column].set(
            xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", title=f"{frame / RATE_HZ:.1f} s"
        )
        axes[1, column].set(xlim=(-reach, reach), ylim=(-0.02, top), aspect="equal", xlabel="x [m]")
    axes[0, 0].set_ylabel("from above: x [m]")
    axes[1, 0].set_ylabel("side: z [m]")
    figure.suptitle(f"{title}. Blue: front of the fabric, brown: back")
    save_figure(figure, path, dpi=75)


def outcome_picture(path: Path, episode: Episode, faces: np.ndarray, task: Task) -> None:
    """Garment at the end against the outline of the ideal fold, and its height and speed over time."""
    figure = Figure(figsize=(9.5, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    end, ideal = episode.garment_m[-1].astype(float), ideal_fold(episode.garment_m[0].astype(float), task)
    left.add_collection(PolyCollection(_flip(ideal)[faces], facecolor="0.85", edgecolor="0.85", label="ideal fold"))
    _draw(left, end, faces, right=-end[:, 1], up=end[:, 0], depth=end[:, 2], alpha=0.6)
    left.autoscale_view()
    iou = episode.about["figures"]["iou"]
    left.set(aspect="equal", xlabel="-y [m]", ylabel="x [m]", title=f"end (colour) on ideal fold (grey), IoU {iou:.2f}")
    time = episode.time_s
    right.plot(time, 1000 * episode.garment_m[:, :, 2].max(axis=1), label="highest vertex [mm]")
    for side, name in enumerate(("left", "right")):
        right.plot(time, 100 * episode.openness[:, side], ":", label=f"{name} gripper openness [%]")
    right.set(xlabel="time [s]", title="height of the garment, grippers")
    right.legend(fontsize=8)
    save_figure(figure, path, dpi=85)


def _flip(points: np.ndarray) -> np.ndarray:
    return np.stack([-points[:, 1], points[:, 0]], axis=1)


def _draw(
    axes: Axes,
    points: np.ndarray,
    faces: np.ndarray,
    *,
    right: np.ndarray,
    up: np.ndarray,
    depth: np.ndarray,
    alpha=1.0,
) -> None:
    order = np.argsort(depth[faces].mean(axis=1), kind="stable")
    a, b, c = (points[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    light = 0.55 + 0.45 * np.abs(normal @ np.array([0.3, 0.2, 0.93]))
    color = np.where((normal[:, 2] >= 0)[:, None], FRONT, BACK) * light[:, None]
    polygons = np.stack([right, up], axis=1)[faces[order]]
    axes.add_collection(
        PolyCollection(polygons, facecolor=color[order], edgecolor="none", alpha=alpha, antialiased=False)
    )
