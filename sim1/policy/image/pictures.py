"""Pictures of an image policy: error by what the pictures show, the looks themselves, the loss."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from lerobot.configs import PreTrainedConfig
from matplotlib.figure import Figure

from sim1.policy.image.clips import Clip
from sim1.policy.image.frames import open_frames
from sim1.policy.image.measures import ALL_TITLES, Mean, Point
from sim1.policy.image.shifts import TITLES

ROWS = 4  # of looks at most
COLOR, STILL = "#1f6fb4", "#8a8f98"


def draw_errors(points: Sequence[Point]) -> Figure:
    """Joint and openness error for each kind of pictures, beside standing still."""
    figure = Figure(figsize=(9.5, 1.3 + 0.5 * len(points)), layout="constrained")
    figure.suptitle("Open-loop error on held-out trajectories (simulation, scripted expert)")
    panels = figure.subplots(1, 2, sharey=True)
    rows = np.arange(len(points))
    for axes, label, means, still in (
        (
            panels[0],
            "joint commands (degrees)",
            [_degrees(p.joint_rad) for p in points],
            [np.degrees(p.hold_joint_rad) for p in points],
        ),
        (panels[1], "gripper openness (1)", [p.openness for p in points], [p.hold_openness for p in points]),
    ):
        for row, mean in zip(rows, means):
            low, high = mean.interval or (mean.value, mean.value)
            axes.plot([low, high], [row, row], color=COLOR, lw=2.5, solid_capstyle="butt")
        axes.plot([mean.value for mean in means], rows, "o", color=COLOR, label="policy, mean and 95 %")
        axes.plot(still, rows, "|", color=STILL, ms=14, mew=2, label="standing still")
        axes.set(xlabel=label, xlim=(0, None), ylim=(len(points) - 0.5, -0.5))
        axes.grid(axis="x", color="#e4e7eb", lw=0.8)
        axes.set_axisbelow(True)
    names = [
        f"{ALL_TITLES[p.pictures]}\n{p.trajectory_count} {'trajectory' if p.trajectory_count == 1 else 'trajectories'}"
        for p in points
    ]
    panels[0].set_yticks(rows, names, fontsize=9)
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=9, frameon=False
    )
    return figure


def draw_looks(views: Path, clips: Sequence[Clip], config: PreTrainedConfig) -> Figure:
    """A frame of each trajectory in every look, as the policy gets it, taken from the videos."""
    frames = open_frames(views, [clip.episode_index for clip in clips], config, commands=False)
    camera = min(frames.meta.camera_keys)
    shown = list(dict.fromkeys((clip.trajectory.garment, clip.trajectory.name) for clip in clips))[:ROWS]
    figure = Figure(figsize=(1.9 * len(TITLES), 0.55 + 1.55 * len(shown)), layout="constrained")
    figure.suptitle("One thing changed at a time, a third of the way through (rendered)", fontsize=10)
    grid = figure.subplots(len(shown), len(TITLES), squeeze=False)
    for axes, title in zip(grid[0], TITLES.values()):
        axes.set_title(title, fontsize=9)
    for line, name in zip(grid, shown):
        own = [clip for clip in clips if (clip.trajectory.garment, clip.trajectory.name) == name]
        for axes, clip in zip(line, own, strict=True):
            row = frames.meta.episodes[clip.episode_index]
            place = (2 * row["dataset_from_index"] + row["dataset_to_index"]) // 3
            image = frames[frames.absolute_to_relative_idx[place]][camera]
            if image.ndim == 4:  # a policy that looks back gets several frames; the last one is now
                image = image[-1]
            axes.imshow(image.permute(1, 2, 0).numpy(), interpolation="antialiased")
            axes.set(xticks=[], yticks=[])
        line[0].set_ylabel(" ".join(name), fontsize=9)
    return figure


def draw_loss(losses: pd.DataFrame) -> Figure:
    """Training loss over steps of one network with its running mean, or the running means of several."""
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    networks = [own.to_numpy() for _, own in losses.groupby("seed")["loss"]]
    for place, own in enumerate(networks):
        if len(networks) == 1:
            axes.plot(np.arange(1, len(own) + 1), own, color=STILL, lw=0.8, label="one batch")
        width = max(1, len(own) // 20)
        if width > 1 or len(networks) > 1:
            mean = np.convolve(own, np.full(width, 1 / width), mode="valid")
            label = f"mean of {width}" + (f", {len(networks)} networks" if len(networks) > 1 else "")
            axes.plot(np.arange(width, len(own) + 1), mean, color=COLOR, lw=2, label="" if place else label)
    axes.set(xlabel="training step", ylabel="loss (lerobot's, normalised)", title="Training")
    axes.legend(frameon=False)
    return figure


def _degrees(mean: Mean) -> Mean:
    interval = mean.interval and type(mean.interval)(*np.degrees(mean.interval))
    return Mean(value=float(np.degrees(mean.value)), interval=interval)
