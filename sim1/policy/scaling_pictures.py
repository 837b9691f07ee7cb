"""Pictures of the scaling curves."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim1.policy.scaling import Point, PowerLaw


def draw_error(points: Sequence[Point], fit: PowerLaw | str) -> Figure:
    """Held-out action error against training size."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    shown = [point for point in points if point.joint_error_rad is not None]
    sizes = np.array([point.size for point in shown], dtype=float)
    means = np.degrees([point.joint_error_rad for point in shown])
    bars = np.degrees([point.joint_error_interval_rad for point in shown]).T
    axes.errorbar(
        sizes, means, yerr=np.abs(bars - means), fmt="o", capsize=4, color="#1f6fb4", label="policy, mean and 95 %"
    )
    axes.plot(
        sizes,
        np.degrees([point.hold_joint_error_rad for point in shown]),
        "--",
        color="#8a8f98",
        label="standing still",
    )
    if isinstance(fit, PowerLaw):
        line = np.geomspace(sizes.min(), sizes.max(), 100)
        label = (
            f"{np.degrees(fit.scale_rad):.3g}° · n^−{fit.exponent:.2f}" if fit.exponent >= 0 else "power law (rising)"
        )
        axes.plot(line, np.degrees(fit.at(line)), color="#1f6fb4", lw=1, label=label)
    _size_axis(axes, sizes)
    axes.set(ylabel="error of predicted joint commands (degrees)", ylim=(0, None), title="Held-out action error")
    axes.legend(frameon=False)
    return figure


def draw_success(points: Sequence[Point]) -> Figure:
    """Closed-loop success against training size."""
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    axes = figure.subplots()
    shown = [point for point in points if point.trial_count]
    sizes = np.array([point.size for point in shown], dtype=float)
    share = np.array([100 * point.success_count / point.trial_count for point in shown])
    bars = 100 * np.array([point.success_interval for point in shown]).T
    axes.errorbar(sizes, share, yerr=np.abs(bars - share), fmt="o", capsize=4, color="#b4531f")
    for point, x, y in zip(shown, sizes, share):
        axes.annotate(f"{point.success_count} of {point.trial_count}", (x, y), (6, 6), textcoords="offset points")
    _size_axis(axes, sizes)
    axes.set(ylabel="success (%), 95 % Wilson interval", ylim=(-4, 104), title="Closed-loop success, simulated")
    return figure


def _size_axis(axes: Axes, sizes: np.ndarray) -> None:
    axes.set_xscale("log")
    axes.set_xticks(sizes, [f"{size:g}" for size in sizes])
    axes.set_xticks([], minor=True)
    axes.margins(x=0.15)
    axes.set_xlabel("training trajectories")
    axes.grid(alpha=0.25)
