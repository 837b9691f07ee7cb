"""The contact sheet of an artifact of rendered episodes."""

import json
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from sim1.picture_file import save_figure

COLUMNS, MAX_ROWS = 5, 8


def write_contact_sheet(artifact: Path, *, title: str) -> None:
    """Write `contact_sheet.png`: a row per clip and camera, frames evenly from first to last, with the time below."""
    rows = []
    for about in sorted(artifact.glob("episodes/*/v*/appearance.json")):
        rate_hz = json.loads(about.read_text())["rate_hz"]
        for camera in sorted(path for path in about.parent.iterdir() if path.is_dir()):
            rows.append((f"{about.parts[-3]} {about.parts[-2]}\n{camera.name}", rate_hz, sorted(camera.glob("*.png"))))
    # All episodes have a place in a short sheet: rows are spread over them.
    rows = [rows[i] for i in np.unique(np.linspace(0, len(rows) - 1, MAX_ROWS).round().astype(int))] if rows else []
    figure = Figure(figsize=(8.0, 0.6 + 1.35 * max(len(rows), 1)), layout="constrained", dpi=80)
    figure.suptitle(title if rows else f"{title}: none, no trajectory was accepted")
    axes = figure.subplots(max(len(rows), 1), COLUMNS, squeeze=False)
    for axis in axes.ravel():
        axis.set_axis_off()
    for line, (label, rate_hz, frames) in zip(axes, rows):
        chosen = np.linspace(0, len(frames) - 1, COLUMNS).round().astype(int)
        for axis, index in zip(line, chosen):
            axis.imshow(np.asarray(Image.open(frames[index])), interpolation="antialiased")
            axis.set_title(f"{index / rate_hz:.1f} s", fontsize=7, pad=2)
        line[0].text(-0.08, 0.5, label, transform=line[0].transAxes, ha="right", va="center", fontsize=7)
    save_figure(figure, artifact / "contact_sheet.png")
