"""Pictures of a diagnosis."""

from pathlib import Path

import matplotlib
import numpy as np

from sim1.cloth.precise.material import marker_points
from sim1.mismatch.diagnose import Diagnosis
from sim1.recording.bundle import Bundle, Recording

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from sim1.picture_file import save_figure

COLORS = {"baseline": "tab:red", "augmented": "tab:blue"}
PANEL_IN = 2.7  # inches, how wide one of four moments is drawn
AROUND_IN = 1.5  # above and below it, for titles and legend
FLAT = 0.15  # height over width of what markers pass through, below which it is seen from above


def draw_forces(path: Path, bundle: Bundle, found: Diagnosis) -> None:
    """Map of the missing force on the cloth and its course in every recording."""
    forces = found.located.forces
    points = marker_points(bundle)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), width_ratios=[1, 1.6], layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, wspace=0.05)  # two labels meet between the halves
    if len(forces):
        size = 1e3 * np.sqrt(found.located.marker_power_n2)
        # From nothing on: a force that is the same everywhere looks so.
        dots = left.scatter(*(1e3 * points.T), c=size, s=140, cmap="magma_r", edgecolors="0.6", vmin=0)
        figure.colorbar(dots, ax=left, label="missing force per marker [mN rms]")
        courses = [1e3 * np.sqrt((force.force_n**2).mean((1, 2))) for force in forces]
        for force, course in zip(forces, courses, strict=True):
            right.plot(force.time_s, course, label=force.name, lw=1.2)
        floor = 1e3 * float(np.sqrt(np.mean([force.floor_n**2 for force in forces])))
        highest = max(floor, *(course.max() for course in courses))
        right.set_ylim(0, 1.1 * highest or None)  # one that is steady lies below the edge
        if floor:
            right.axhline(floor, color="k", ls=":", label="noise alone")
        right.legend(fontsize=8)
    left.set(xlabel="u [mm]", ylabel="v [mm]", aspect="equal", title="on the cloth")
    left.invert_yaxis()
    right.set(xlabel="time [s]", ylabel="missing force [mN rms per coordinate]", title="over time")
    save_figure(figure, path, dpi=110)
    plt.close(figure)


def draw_heldout_error(path: Path, bundle: Bundle, found: Diagnosis) -> None:
    """Error over time on the recordings that no fit has seen, before and after, with the noise drawn."""
    names = found.heldout
    figure, axes = plt.subplots(1, len(names), figsize=(9, 3.4), squeeze=False, layout="constrained")
    for axis, name in zip(axes[0], names, strict=True):
        recording = next(r for r in bundle.recordings if r.name == name)
        for label, color in COLORS.items():
            told_m = found.heldout_markers_m[label].get(name)
            if told_m is None:  # named in the legend, so that nobody takes one curve for both
                axis.plot([], [], color=color, label=f"{label}: cannot be simulated")
                continue
            error = _error_m(recording, told_m)
            axis.plot(recording.time_s, 1e3 * error, color=color, label=label, lw=1.2)
        axis.axhline(1e3 * found.noise_m, color="k", ls=":", label="noise")
        axis.set(xlabel="time [s]", ylabel="error [mm rms]", title=name, ylim=(0, None))
        axis.legend(fontsize=8)
    save_figure(figure, path, dpi=110)
    plt.close(figure)


def draw_key_frames(path: Path, bundle: Bundle, found: Diagnosis) -> None:
    """Measured and simulated markers of the held-out recording at four moments: seen across the way that they move most.

    A sheet that lies flat is seen from above.
    """
    name = found.heldout[0]
    recording = next(r for r in bundle.recordings if r.name == name)
    runs = {label: run[name] for label, run in found.heldout_markers_m.items() if name in run}
    worst = next(iter(runs), None)
    error = _error_m(recording, runs[worst] if worst else recording.markers_m)
    frames = [int(part[np.argmax(error[part])]) for part in np.array_split(np.flatnonzero(np.isfinite(error)), 4)]
    side = int(np.ma.masked_invalid(recording.markers_m[..., :2]).std(axis=0).mean(axis=0).argmax())
    low, high = np.nanmin(recording.markers_m, axis=(0, 1)), np.nanmax(recording.markers_m, axis=(0, 1))
    flat = high[2] - low[2] < FLAT * (high - low)[:2].max()
    across, up = (0, 1) if flat else (side, 2)
    wide, tall = (high - low)[[across, up]]
    height = AROUND_IN + np.clip(PANEL_IN * tall / max(wide, 1e-6), 0.8, 5.0)
    figure, axes = plt.subplots(1, 4, figsize=(12, height), sharex=True, sharey=True, layout="constrained")
    for axis, frame in zip(axes, frames, strict=True):
        seen = 1e3 * recording.markers_m[frame][:, [across, up]]
        for label, run in runs.items():
            color = COLORS[label]
            told = 1e3 * run[frame][:, [across, up]]
            axis.plot(*np.stack([seen, told], axis=1).transpose(2, 1, 0), color=color, lw=0.8)
            axis.scatter(*told.T, s=9, color=color, label=label)
        axis.scatter(*seen.T, s=22, facecolors="none", edgecolors="k", label="measured")
        axis.set(xlabel=f"{'xyz'[across]} [mm]", title=f"{recording.time_s[frame]:.2f} s", aspect="equal")
    axes[0].set_ylabel(f"{'xyz'[up]} [mm]")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    said = f"the moments at which the model ({worst}) is most wrong in each quarter" if worst else "cannot be simulated"
    figure.suptitle(f"{name}: {said}")
    save_figure(figure, path, dpi=110)
    plt.close(figure)


def _error_m(recording: Recording, told_m: np.ndarray) -> np.ndarray:
    """Root mean square per coordinate (N,) of the markers seen in each frame; NaN where none was."""
    square = np.where(recording.seen[..., None], told_m - recording.markers_m, 0.0) ** 2
    count = 3 * recording.seen.sum(1)
    return np.sqrt(np.divide(square.sum((1, 2)), count, out=np.full(len(count), np.nan), where=count > 0))
