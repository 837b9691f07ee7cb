"""Pictures of a written dataset, taken from its own files rather than from what went into them."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim1.dataset.check_videos import frame_at
from sim1.dataset.tables import column, read_tables
from sim1.picture_file import save_figure

COLUMNS = 5


def write_frames_picture(out: Path, provenance: pd.DataFrame) -> None:
    """`frames.png`: frames of each garment's first episode, evenly from first to last, decoded from the video."""
    tables = read_tables(out / "lerobot")
    key = min(name for name, feature in tables.info["features"].items() if feature["dtype"] == "video")
    firsts = provenance.drop_duplicates("garment")
    figure = Figure(figsize=(8.0, 0.5 + 1.4 * len(firsts)), layout="constrained", dpi=80)
    figure.suptitle(f"First episode of every garment, {key}")
    axes = figure.subplots(len(firsts), COLUMNS, squeeze=False)
    for line, row in zip(axes, firsts.itertuples()):
        episode = tables.episodes.loc[row.episode_index]
        path = tables.info["video_path"].format(
            video_key=key,
            chunk_index=episode[f"videos/{key}/chunk_index"],
            file_index=episode[f"videos/{key}/file_index"],
        )
        for axis, frame in zip(line, np.linspace(0, row.frame_count - 1, COLUMNS).round().astype(int)):
            time_s = frame / tables.info["fps"]
            axis.imshow(
                frame_at(out / "lerobot" / path, episode[f"videos/{key}/from_timestamp"] + time_s),
                interpolation="antialiased",
            )
            axis.set_title(f"{time_s:.1f} s", fontsize=7, pad=2)
            axis.set_axis_off()
        line[0].text(-0.08, 0.5, row.garment, transform=line[0].transAxes, ha="right", va="center", fontsize=8)
    save_figure(figure, out / "frames.png")


def write_motion_picture(out: Path, provenance: pd.DataFrame) -> None:
    """`motion.png`: state and action over time in each garment's first episode, an arm per column."""
    tables = read_tables(out / "lerobot")
    names = tables.info["features"]["observation.state"]["names"]
    arms = [[index for index, name in enumerate(names) if name.startswith(arm)] for arm in ("left", "right")]
    firsts = provenance.drop_duplicates("garment")
    figure = Figure(figsize=(9.0, 0.6 + 1.9 * len(firsts)), layout="constrained", dpi=80)
    figure.suptitle("First episode of every garment: state (lines) and action (dashes)")
    axes = figure.subplots(len(firsts), len(arms), squeeze=False, sharex="row", sharey=True)
    for line, row in zip(axes, firsts.itertuples()):
        frames = tables.frames[tables.frames["episode_index"] == row.episode_index]
        states, actions = column(frames, "observation.state"), column(frames, "action")
        for axis, arm in zip(line, arms):
            for color, index in enumerate(arm):
                label = names[index].split("_", 1)[1].replace("_rad", "").replace("_", " ")
                axis.plot(frames["timestamp"], states[:, index], color=f"C{color}", linewidth=1.2, label=label)
                axis.plot(frames["timestamp"], actions[:, index], color=f"C{color}", linewidth=0.8, linestyle="--")
            axis.set_title(f"{row.garment}, {names[arm[0]].split('_')[0]} arm", fontsize=8)
            axis.tick_params(labelsize=7)
            axis.set_xlabel("time (s)", fontsize=7)
        line[0].set_ylabel("angle (rad), openness (1)", fontsize=7)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=7, fontsize=7)
    save_figure(figure, out / "motion.png")
