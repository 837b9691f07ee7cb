"""Speed profiles of demonstrated and generated transitions side by side."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from sim1.episode import RATE_HZ
from sim1.motion.likeness.comparison import Paths
from sim1.motion.likeness.features import Movement
from sim1.motion.likeness.smoothness import speed
from sim1.picture_file import save_figure

COLORS = {"diffusion": "tab:blue", "straight": "tab:red", "minimum_jerk": "tab:orange", "slicing": "tab:green"}
MOST = 24  # lines of a kind in one panel: more are a carpet
COLUMNS = 4  # places in the task that are shown


def draw_likeness(path: Path, demos: Paths, paths: dict[str, Paths]) -> None:
    """A row of panels per method, a column per place in the task: speed of the arm that goes further, over time."""
    orders = sorted({item.order for item in demos.movements})[:COLUMNS]
    figure = Figure(figsize=(3.6 * len(orders) + 0.8, 2.1 * len(paths) + 0.7), layout="constrained")
    grid = np.reshape(
        figure.subplots(len(paths), len(orders), sharex="col", sharey=True, squeeze=False), (-1, len(orders))
    )
    for row, (name, others) in zip(grid, paths.items(), strict=True):
        for axes, order in zip(row, orders, strict=True):
            for movements, style in (
                (demos.movements, {"color": "0.35", "linewidth": 1.4, "alpha": 0.6}),
                (others.movements, {"color": COLORS[name], "linewidth": 0.9, "alpha": 0.7}),
            ):
                for movement in [item for item in movements if item.order == order][:MOST]:
                    profile = _profile(movement)
                    axes.plot((np.arange(len(profile)) + 0.5) / RATE_HZ, profile, **style)
        row[0].set_ylabel(f"{name.replace('_', ' ')}\nspeed [m/s]")
    for axes, order in zip(grid[0], orders, strict=True):
        axes.set_title(f"transition {order + 1}", fontsize=10)
    for axes in grid[-1]:
        axes.set_xlabel("time [s]")
    figure.suptitle("Demonstrated transitions (grey) and generated ones (colour)", fontsize=11)
    save_figure(figure, path)


def _profile(movement: Movement) -> np.ndarray:
    position = movement.path.position_m
    arm = int(np.linalg.norm(np.diff(position, axis=0), axis=-1).sum(axis=0).argmax())
    return speed(position[:, arm])
