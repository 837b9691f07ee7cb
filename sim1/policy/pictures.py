"""A picture of what a policy commands."""

import numpy as np
from matplotlib.figure import Figure

from sim1.episode import JOINT_COUNT
from sim1.policy.episodes import Trajectory
from sim1.policy.model import ChunkPolicy


def draw_command(policy: ChunkPolicy, trajectory: Trajectory, *, held_out: bool) -> Figure:
    """Recorded commands of both arms and, dashed, what the policy answers to every recorded observation."""
    said = policy.predict(trajectory.state, trajectory.keypoints, trajectory.garment)[:, 0]
    frames = np.arange(len(said))
    figure = Figure(figsize=(9, 5), layout="constrained")
    rows = figure.subplots(2, 2, sharex=True, height_ratios=(3, 1))
    for side, name in enumerate(("left", "right")):
        first = side * (JOINT_COUNT + 1)
        for joint in range(JOINT_COUNT):
            color = f"C{joint}"
            rows[0, side].plot(
                frames, np.degrees(trajectory.action[:, first + joint]), color=color, lw=1.2, label=f"joint {joint + 1}"
            )
            rows[0, side].plot(frames, np.degrees(said[:, first + joint]), "--", color=color, lw=1.2)
        rows[1, side].plot(frames, trajectory.action[:, first + JOINT_COUNT], color="k", lw=1.2)
        rows[1, side].plot(frames, said[:, first + JOINT_COUNT], "--", color="k", lw=1.2)
        rows[0, side].set(title=f"{name} arm", ylabel="command (degrees)")
        rows[1, side].set(xlabel="frame of the dataset", ylabel="openness", ylim=(-0.1, 1.1))
    figure.legend(
        *rows[0, 0].get_legend_handles_labels(),
        loc="outside lower center",
        ncols=JOINT_COUNT,
        fontsize=9,
        frameon=False,
    )
    kind = "held out" if held_out else "a training trajectory: none was held out"
    figure.suptitle(f"{trajectory.garment} {trajectory.name} ({kind}): recorded, and policy dashed")
    return figure
