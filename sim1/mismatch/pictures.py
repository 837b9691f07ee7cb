"""Pictures of a calibration and of what it leaves unexplained."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from sim1.mismatch.locate import Location
from sim1.recording.bundle import Bundle, Recording
from sim1.recording.pictures import save

COLOURS = {"baseline": "tab:orange", "with air drag": "tab:blue"}


def draw_heldout(path: Path, recording: Recording, simulated_m: dict[str, np.ndarray]) -> None:
    """Measured against simulated markers over time on motion that no fit has seen, for the three that move most."""
    axis = int(np.argmax(np.nanstd(recording.markers_m, axis=0).mean(0)))
    travel = np.nanstd(recording.markers_m[..., axis], axis=0)
    chosen = np.argsort(travel)[[len(travel) // 4, len(travel) // 2, -1]]
    figure = Figure(figsize=(9, 6.2), layout="constrained")
    panels = figure.subplots(4, 1, sharex=True, height_ratios=(1, 1, 1, 1))
    for panel, marker in zip(panels, chosen, strict=False):
        panel.plot(recording.time_s, 1e3 * recording.markers_m[:, marker, axis], "k.", ms=3, label="measured")
        for name, markers in simulated_m.items():
            panel.plot(recording.time_s, 1e3 * markers[:, marker, axis], color=COLOURS[name], lw=1.2, label=name)
        panel.set_ylabel(f"marker {marker}\n{'xyz'[axis]} [mm]")
        panel.grid(alpha=0.3)
    for name, markers in simulated_m.items():
        error = np.sqrt(np.nanmean(np.square(markers - recording.markers_m), axis=(1, 2)))
        panels[3].plot(recording.time_s, 1e3 * error, color=COLOURS[name], lw=1.2)
    panels[3].set_ylabel("rms error\n[mm]")
    panels[3].set_xlabel("time [s]")
    panels[3].grid(alpha=0.3)
    panels[0].legend(ncols=3, fontsize=8, loc="upper left")
    figure.suptitle(f"Held-out recording {recording.name}: no fit has seen it", fontsize=11)
    save(figure, path)


def draw_parameters(path: Path, results: list[dict[str, Any]], accepted: bool) -> None:
    """Each parameter over its prior mean: prior in grey, estimates with their 95 % intervals."""
    names = [row["name"] for row in results[-1]["parameters"]]
    figure = Figure(figsize=(8, 0.75 * len(names) + 1.6), layout="constrained")
    panel = figure.subplots()
    for place, name in enumerate(names):
        for offset, (label, result) in enumerate(zip(COLOURS, results, strict=False)):
            row = next((row for row in result["parameters"] if row["name"] == name), None)
            if row is None:
                continue
            if offset == len(results) - 1:
                edges = (max(row["prior_low"] / row["prior"], 1e-3), row["prior_high"] / row["prior"])
                panel.fill_betweenx([place - 0.38, place + 0.38], *edges, color="0.85", lw=0)
            y = place - 0.15 + 0.3 * offset
            panel.plot([row["low"] / row["prior"], row["high"] / row["prior"]], [y, y], color=COLOURS[label], lw=2)
            panel.plot(row["value"] / row["prior"], y, "o", color=COLOURS[label], ms=5)
            panel.annotate(
                f"{row['value']:.3g} {row['unit'] if row['unit'] != '1' else ''}",
                (row["value"] / row["prior"], y),
                xytext=(0, 5),
                textcoords="offset points",
                fontsize=7,
            )
    for label in list(COLOURS)[: len(results)]:
        panel.plot([], [], "o-", color=COLOURS[label], label=label)
    panel.fill_between([], [], [], color="0.85", label="prior, 95 %")
    panel.set_yticks(range(len(names)), names)
    panel.set_xscale("log")
    panel.axvline(1, color="0.5", lw=0.8)
    panel.set_xlabel("value / prior mean [1]")
    panel.legend(fontsize=8, loc="best")
    kept = "air drag kept" if accepted else "no effect beyond the baseline kept"
    panel.set_title(
        f"Parameters with 95 % intervals ({kept}); ratios to the density are what motion determines", fontsize=9
    )
    save(figure, path)


def draw_place(path: Path, bundle: Bundle, location: Location, title: str) -> None:
    """Unexplained motion on the cloth and over time."""
    material = bundle.mesh.material_m
    spot = (material[bundle.mesh.faces[bundle.anchors.face]] * bundle.anchors.weight[..., None]).sum(1)
    figure = Figure(figsize=(9, 4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.5))
    left.triplot(Triangulation(*material.T, bundle.mesh.faces), color="0.85", lw=0.6)
    shown = left.scatter(
        *spot.T, c=1e3 * np.sqrt(location.marker_excess_m2), s=120, cmap="inferno_r", edgecolor="0.3", lw=0.5, vmin=0
    )
    for hold in bundle.recordings[0].holds:
        left.plot(*material[hold.vertices].T, "s", color="tab:red", ms=5)
    left.set_aspect("equal")
    left.invert_yaxis()
    left.set_xlabel("u [m]")
    left.set_ylabel("v [m]")
    left.set_title("where (red: held)", fontsize=10)
    figure.colorbar(shown, ax=left, label="rms beyond noise and mesh [mm]", shrink=0.8)
    names = [recording.name for recording in bundle.recordings]
    for row, name in enumerate(names):
        for window in location.windows:
            if window.recording == name:
                right.barh(
                    row,
                    window.to_s - window.from_s,
                    left=window.from_s,
                    height=0.7,
                    color=_shade(window.share, location),
                    ec="0.8",
                    lw=0.3,
                )
    right.set_yticks(range(len(names)), names)
    right.invert_yaxis()
    right.set_xlabel("time [s]")
    right.set_title("when (darker: larger share)", fontsize=10)
    figure.suptitle(title, fontsize=11)
    save(figure, path)


def _shade(share: float, location: Location) -> tuple[float, float, float]:
    most = max((window.share for window in location.windows), default=0.0)
    level = share / most if most else 0.0
    return (1 - 0.75 * level, 1 - 0.85 * level, 1 - 0.6 * level)
