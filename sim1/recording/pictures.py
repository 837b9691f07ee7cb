"""Pictures of a recording bundle."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from sim1.picture_file import save_figure
from sim1.recording.bundle import Bundle


def draw_paths(path: Path, bundle: Bundle, title: str) -> None:
    """Where the markers went, seen across the motion, one panel per recording; colour is time."""
    shown = bundle.recordings[:4]
    figure = Figure(figsize=(3.2 * len(shown) + 1.2, 3.8), layout="constrained")
    panels = figure.subplots(1, len(shown), sharex=True, sharey=True, squeeze=False)[0]
    spread = np.nanmax([np.nanstd(recording.markers_m[..., :2], axis=0).mean(0) for recording in shown], axis=0)
    side = int(np.argmax(spread))
    for panel, recording in zip(panels, shown, strict=True):
        time = np.broadcast_to(recording.time_s[:, None], recording.seen.shape)
        points = recording.markers_m[recording.seen]
        picture = panel.scatter(
            points[:, side], points[:, 2], c=time[recording.seen], s=1.5, cmap="viridis", rasterized=True
        )
        for track in recording.drives.values():
            panel.plot(track.position_m[:, side], track.position_m[:, 2], color="tab:red", lw=1.5)
        panel.set_title(recording.name, fontsize=10)
        panel.set_xlabel(f"{'xy'[side]} [m]")
        panel.set_aspect("equal")
        panel.grid(alpha=0.3)
    panels[0].set_ylabel("z [m]")
    figure.colorbar(picture, ax=panels, label="time [s]")
    figure.suptitle(f"Markers, and drives in red ({title})", fontsize=11)
    save_figure(figure, path, dpi=90)
