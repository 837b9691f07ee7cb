"""Picture of a scan: its points from the front and from the left, in their colours."""

from pathlib import Path

import numpy as np

from sim1.picture_file import save_figure
from sim1.scan.cloud import Scan

_MOST = 30_000  # points drawn


def draw_scan(scan: Scan, title: str, path: Path) -> None:
    """Write a PNG; nearer points cover farther ones."""
    from matplotlib.figure import Figure

    points, colors = scan.cloud.points_m, scan.cloud.colors / 255.0
    step = max(1, len(points) // _MOST)
    flat = np.ptp(points[:, 2]) < 0.3 * np.ptp(points[:, :2], axis=0).min()
    views = (
        (("from above", (0, 1, 2), (1, 1)), ("from the front", (1, 2, 0), (1, 1)))
        if flat
        else (("from the front", (1, 2, 0), (1, 1)), ("from its right", (0, 2, 1), (1, -1)))
    )
    figure = Figure(figsize=(9, 4.8), dpi=90, layout="constrained")
    figure.suptitle(f"{title}, {len(points)} points, {len(scan.scanner_to_world)} views")
    for place, (name, (across, up, depth), (_, toward)) in enumerate(views, 1):
        axes = figure.add_subplot(1, 2, place)
        order = np.argsort(points[::step, depth] * toward)
        axes.scatter(*points[::step][order][:, [across, up]].T, c=colors[::step][order], s=1.2, linewidths=0)
        axes.set(title=name, aspect="equal", xlabel=f"{'xyz'[across]} (m)", ylabel=f"{'xyz'[up]} (m)")
    save_figure(figure, path)
