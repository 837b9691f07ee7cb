"""A picture of how often an image policy folds in every shift."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from sim1.policy import paper
from sim1.policy.image_trials.measures import ShiftTried

COLOR, PAPER_COLOR = "#1f6fb4", "#8a8f98"


def draw_success(tried: Sequence[ShiftTried]) -> Figure:
    """Success by shift with intervals, and what the paper prints for a real robot."""
    figure = Figure(figsize=(7.5, 1.7 + 0.45 * len(tried)), layout="constrained")
    figure.suptitle("Closed loop with rendered pictures, simulated", fontsize=11)
    axes = figure.subplots()
    rows = np.arange(len(tried))
    for row, one in zip(rows, tried):
        axes.plot([100 * limit for limit in one.interval], [row, row], color=COLOR, lw=2.5, solid_capstyle="butt")
    shares = [100 * one.success_count / one.trial_count for one in tried]
    axes.plot(shares, rows, "o", color=COLOR, label="here, 95 % interval")
    printed = [paper.ABLATION[paper.FULL].get(one.shift, np.nan) for one in tried]
    axes.plot(printed, rows, "D", color=PAPER_COLOR, mfc="none", label="paper: a real robot, a T-shirt, another policy")
    names = [f"{one.shift}\n{one.success_count} of {one.trial_count}" for one in tried]
    axes.set_yticks(rows, names, fontsize=9)
    axes.set(xlabel="success (%)", xlim=(-3, 103), ylim=(len(tried) - 0.5, -0.5))
    axes.grid(axis="x", color="#e4e7eb", lw=0.8)
    axes.set_axisbelow(True)
    handles = axes.get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    return figure
