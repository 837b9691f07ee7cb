"""Pictures of the motion room."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from sim1.episode import ARMS, RATE_HZ, Episode
from sim1.motion.poses import ToolPath
from sim1.motion.segments import Span
from sim1.picture_file import save_figure

ARM_COLORS = {"left": "tab:blue", "right": "tab:orange"}
SHADE = {"interacting": "#f6d9b0", "moving": "#ffffff"}


def draw_segmentation(path: Path, demo: str, episode: Episode, measured: ToolPath, spans: list[Span]) -> None:
    """Openness and tool height over time, interacting spans shaded."""
    figure = Figure(figsize=(9, 4.6), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True)
    for index, arm in enumerate(ARMS):
        style = {"color": ARM_COLORS[arm], "linestyle": "-" if index == 0 else "--"}  # both often coincide
        top.plot(episode.time_s, episode.openness[:, index], label=f"{arm} arm", **style)
        height_mm = 1000 * measured.position_m[:, index, 2]
        bottom.plot(episode.time_s, height_mm, **style)
    for axes in (top, bottom):
        for span in spans:
            if span.kind == "interacting":
                axes.axvspan(span.start / RATE_HZ, span.end / RATE_HZ, color=SHADE["interacting"], zorder=0)
    top.set_ylabel("openness (1 is open)")
    bottom.set_ylabel("finger tips above table [mm]")
    bottom.set_xlabel("time [s]")
    outcome = "succeeded" if episode.about.get("success") else "failed"
    count = sum(span.kind == "interacting" for span in spans)
    figure.suptitle(f"Demonstration {demo} ({outcome}): {len(spans)} segments, {count} interacting")
    handles, labels = top.get_legend_handles_labels()
    handles.append(Patch(color=SHADE["interacting"]))
    top.legend(handles, [*labels, "interacting"], loc="lower right", fontsize=8, ncols=3)
    save_figure(figure, path, dpi=90)


def draw_training(path: Path, losses: list[float], trivial: float) -> None:
    """Denoising error over the training steps, against that of predicting the interpolant alone."""
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    steps = np.arange(1, len(losses) + 1)
    window = max(len(losses) // 25, 1)
    smooth = np.convolve(losses, np.ones(window) / window, mode="valid")
    axes.plot(steps, losses, color="0.8", linewidth=0.8, label="each step")
    axes.plot(steps[window - 1 :], smooth, color="tab:blue", label=f"mean of {window} steps")
    axes.axhline(trivial, color="tab:red", linestyle="--", label="interpolant alone")
    axes.set(yscale="log", xlabel="training step", ylabel="mean squared error [residual variance]")
    axes.set_title("Training of the motion model")
    axes.legend(fontsize=8)
    save_figure(figure, path, dpi=90)


def draw_samples(path: Path, title: str, pairs: list[tuple[ToolPath, list[ToolPath]]]) -> None:
    """Tool height and speed of demonstrated transitions (black) and of what the model makes between the same ends."""
    figure = Figure(figsize=(3.2 * len(pairs), 4.8), layout="constrained")
    grid = np.reshape(figure.subplots(2, len(pairs), squeeze=False), (2, len(pairs)))
    for column, (shown, samples) in enumerate(pairs):
        arm = int(np.ptp(shown.position_m, axis=0).sum(axis=-1).argmax())
        height, speed = grid[0, column], grid[1, column]
        for sample in samples:
            _draw_path(height, speed, sample, arm, {"color": "tab:blue", "alpha": 0.6, "linewidth": 1.0})
        _draw_path(height, speed, shown, arm, {"color": "black", "linewidth": 1.6})
        height.set_title(f"transition {column + 1}, {ARMS[arm]} arm", fontsize=9)
        speed.set_xlabel("time [s]")
    grid[0, 0].set_ylabel("finger tips above table [mm]")
    grid[1, 0].set_ylabel("speed [m/s]")
    figure.suptitle(title, fontsize=11)
    save_figure(figure, path, dpi=90)


def _draw_path(height: Any, speed: Any, path: ToolPath, arm: int, style: dict[str, Any]) -> None:
    time_s = np.arange(len(path)) / RATE_HZ
    position = path.position_m[:, arm]
    height.plot(time_s, 1000 * position[:, 2], **style)
    speed.plot(time_s[1:], np.linalg.norm(np.diff(position, axis=0), axis=1) * RATE_HZ, **style)


def draw_attempts(
    path: Path, rows: list[dict[str, Any]], ends_m: list[np.ndarray | None], start_m: np.ndarray, count: int
) -> None:
    """The garment of each of these attempts, of `count`, from above: where it was placed and how it ended."""
    columns = min(len(rows), 5)
    lines = -(-len(rows) // columns)
    figure = Figure(figsize=(2.6 * columns, 2.9 * lines + 0.4), layout="constrained")
    grid = np.ravel(figure.subplots(lines, columns, squeeze=False))
    for axes, row, end in zip(grid, rows, ends_m, strict=False):
        placed = start_m @ np.reshape(row["placement"], (4, 4))[:3, :3].T + np.reshape(row["placement"], (4, 4))[:3, 3]
        axes.plot(placed[:, 1], placed[:, 0], ".", color="0.82", markersize=1.5)
        color = "tab:green" if row["success"] else "tab:red"
        if end is not None:
            axes.plot(end[:, 1], end[:, 0], ".", color=color, markersize=1.5)
        label = "success" if row["success"] else row["failure"]
        axes.set_title(f"{row['episode'].replace('_', ' ')}: {label}", fontsize=8)
        axes.set_aspect("equal")
        axes.invert_xaxis()  # as the head camera sees it: left is left
        axes.tick_params(labelsize=7)
    for axes in grid[len(rows) :]:
        axes.set_visible(False)
    figure.supxlabel("y [m]", fontsize=8)
    figure.supylabel("x [m]", fontsize=8)
    which = "Attempts" if len(rows) == count else f"{len(rows)} of {count} attempts"
    figure.suptitle(f"{which} from above: placed (grey) and ended (colour)", fontsize=10)
    save_figure(figure, path, dpi=90)
