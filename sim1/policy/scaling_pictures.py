"""Pictures of the scaling curves."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sim1.policy.lessons import GENERATED, KINDS, NAMES, REAL, SIMULATED
from sim1.policy.scaling import Error, Point, PowerLaw
from sim1.policy.success_law import SuccessLaw
from sim1.policy.tried import Tried

COLORS = {GENERATED: "#1f6fb4", SIMULATED: "#5a8f3c", REAL: "#b4531f"}
BESIDE = {GENERATED: 0.98, SIMULATED: 1.0, REAL: 1.02}  # of one size, so that they do not hide each other
NOTES = {
    GENERATED: (-6, "right"),
    SIMULATED: (6, "left"),
    REAL: (6, "left"),
}  # where counts stand, points beside, and how aligned


def draw_error(points: Sequence[Point], fits: Sequence[PowerLaw]) -> Figure:
    """Action error against training size, a panel for each kind of held-out trajectories."""
    tested = [kind for kind in KINDS if any(error.tested_on == kind for point in points for error in point.errors)]
    figure, panels = _panels(len(tested))
    for axes, kind in zip(panels, tested, strict=True):
        holds = set()
        for trained in KINDS:
            shown = [(p.size, e) for p in points if p.trained_on == trained for e in p.errors if e.tested_on == kind]
            if shown:
                _bars(axes, trained, list(_degrees(shown)))
                holds.add(np.degrees(shown[0][1].hold_joint_error_rad))
        for fit in fits:
            if fit.tested_on == kind:
                sizes = [point.size for point in points if point.trained_on == fit.trained_on]
                line = np.geomspace(min(sizes), max(sizes), 100)
                label = f"{np.degrees(fit.scale_rad):.3g}° · n^{-fit.exponent:.2f}"
                axes.plot(line, np.degrees(fit.at(line)), color=COLORS[fit.trained_on], lw=1, label=label)
        for hold in holds:
            axes.axhline(hold, ls="--", color="#8a8f98", label="standing still")
        _size_axis(axes, points)
        axes.set(ylabel="error of predicted joint commands (degrees)", ylim=(0, None))
        axes.set_title(f"Held-out {NAMES[kind]}", fontsize=10)
        axes.legend(frameon=False, fontsize=8)
    return figure


def draw_success(points: Sequence[Point], laws: Sequence[SuccessLaw | str]) -> Figure:
    """Closed-loop success against training size, a panel for each shift, with what was fitted."""
    shifts = list(dict.fromkeys(tried.shift for point in points for tried in point.trials))
    figure, panels = _panels(len(shifts))
    for axes, shift in zip(panels, shifts, strict=True):
        for trained in KINDS:
            shown = [(p.size, t) for p in points if p.trained_on == trained for t in p.trials if t.shift == shift]
            if shown:
                rows = [(size, *_percent(tried)) for size, tried in shown]
                _bars(axes, trained, rows)
                right, aligned = NOTES[trained]
                for (size, tried), (_, share, *_) in zip(shown, rows, strict=True):
                    note, at = f"{tried.success_count} of {tried.trial_count}", (size * BESIDE[trained], share)
                    axes.annotate(note, at, (right, 4), textcoords="offset points", ha=aligned, fontsize=7)
        for law in laws:
            if isinstance(law, SuccessLaw) and law.shift == shift:
                sizes = [point.size for point in points if point.trained_on == law.trained_on and point.trials]
                line = np.geomspace(min(sizes), max(sizes), 100)
                label = f"log odds {law.offset:.2f} {law.slope:+.2f} ln n"
                axes.plot(line, 100 * law.at(line), color=COLORS[law.trained_on], lw=1, label=label)
        _size_axis(axes, points)
        axes.set(ylabel="success (%), 95 % interval", ylim=(-4, 108))
        axes.set_title(f"Closed loop, simulated: {shift}", fontsize=10)
        axes.legend(frameon=False, fontsize=8)
    return figure


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(1.2 + 4.6 * count, 4.2), layout="constrained")
    return figure, list(np.atleast_1d(figure.subplots(1, count, sharey=True)))


def _bars(axes: Axes, trained: str, rows: list[tuple[float, float, float, float]]) -> None:
    sizes, middle, low, high = np.array(rows, float).T
    bars = np.clip([middle - low, high - middle], 0, None)
    sizes = sizes * BESIDE[trained]
    axes.errorbar(sizes, middle, yerr=bars, fmt="o", capsize=4, color=COLORS[trained], label=NAMES[trained])


def _degrees(shown: list[tuple[int, Error]]) -> Iterator[tuple[float, float, float, float]]:
    for size, error in shown:
        yield size, *np.degrees([error.joint_error_rad, *(error.interval_rad or (error.joint_error_rad,) * 2)])


def _percent(tried: Tried) -> tuple[float, float, float]:
    low, high = tried.interval
    return 100 * tried.success_count / tried.trial_count, 100 * low, 100 * high


def _size_axis(axes: Axes, points: Sequence[Point]) -> None:
    sizes = sorted({point.size for point in points})
    axes.set_xscale("log")
    axes.set_xticks(sizes, [f"{size:g}" for size in sizes])
    axes.set_xticks([], minor=True)
    axes.margins(x=0.2)
    axes.set_xlabel("training trajectories")
    axes.grid(alpha=0.25)
