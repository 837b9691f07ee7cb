"""One picture of the comparison: stretch, shapes, cost against vertices, time at equal stretch."""

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.solver.scenes import Cloth
from benchmarks.solver.stretch import Pull

COLOURS = {
    "SolverAVBD": "#0b6e4f",
    "SolverAVBD, vertices alone": "#7fb685",
    "SolverVBD": "#c8553d",
    "SolverStyle3D": "#7a6fac",
    "MuJoCo": "#8a8d91",
}
SHOWN = 0.05  # strain at which an edge is drawn in the darkest red


def draw(document: dict[str, Any], shapes: list[tuple[Pull, Cloth]], path: Path) -> None:
    """Write the picture (PNG)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(15, 10.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2, gridspec_kw={"height_ratios": (1.15, 1.0)})
    _stretch(axes[0, 0], document["pull"])
    _shapes(axes[0, 1], shapes)
    _cost(axes[1, 0], document)
    _time(axes[1, 1], document["equal_stretch"], document["pull"])
    figure.savefig(path, dpi=100, metadata={"Software": None})


def colour(solver: str) -> str:
    """Of a solver's bars and lines."""
    return COLOURS["MuJoCo" if solver.startswith("MuJoCo") else solver]


def label(row: dict[str, Any]) -> str:
    """Solver and iterations."""
    return row["solver"] if row["iterations"] is None else f"{row['solver']}, {row['iterations']} it."


def _stretch(axis: Any, rows: list[dict[str, Any]]) -> None:
    cloths = list(dict.fromkeys(row["cloth"] for row in rows))
    place, ticks, names = 0.0, [], []
    for cloth in cloths:
        group = [row for row in rows if row["cloth"] == cloth]
        axis.text(0.12, place - 0.75, f"{cloth}, {group[0]['vertices']} vertices", weight="bold", size=9, va="center")
        for row in group:
            strain = 100.0 * ((row["largest_stretch"] or np.inf) - 1.0)
            shown = min(max(strain, 0.1), 2e3)
            axis.barh(place, shown, color=colour(row["solver"]), height=0.75, left=0.0)
            less = "" if row["simulated_s"] > 0.49 else f"  (after {row['simulated_s']:.2g} s)"
            axis.text(shown * 1.08, place, f"{strain:.3g} %{less}", va="center", size=8)
            ticks.append(place)
            names.append(label(row))
            place += 1.0
        place += 1.3
    axis.axvline(5.0, color="black", lw=1.5, ls="--")
    axis.text(5.0, -1.9, "limit 5 %", ha="center", size=9)
    axis.set_xscale("log")
    axis.set_xlim(0.1, 4e3)
    axis.set_ylim(place - 0.8, -1.6)
    axis.set_yticks(ticks, names, size=8)
    axis.set_xlabel("largest strain of any edge during the pull [%]")
    axis.set_title("One corner held and pulled at 0.5 m/s: how far does the cloth stretch?", size=11, pad=18)


def _shapes(axis: Any, shapes: list[tuple[Pull, Cloth]]) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    scale = LinearSegmentedColormap.from_list("strain", ["#2b2d42", "#e6a532", "#d00000"])
    norm = Normalize(0.0, 0.5)
    shift = 0.0
    for result, cloth in shapes:
        points = np.nan_to_num(result.points_m, nan=0.0)
        ends = points[cloth.edges]
        ratio = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1) / cloth.edge_length_m - 1.0
        flat = np.stack(
            [(ends[..., 0] - ends[..., 1]) / np.sqrt(2.0), ends[..., 2]], axis=-1
        )  # seen across the diagonal
        middle = 0.5 * (flat[..., 0].min() + flat[..., 0].max())
        flat[..., 0] += shift - middle
        axis.add_collection(LineCollection(flat, array=ratio, cmap=scale, norm=norm, linewidths=0.7))
        strain = 100.0 * (result.largest - 1.0)
        name = result.contestant.name.replace(", ", "\n").replace(" edges", "\nedges")
        axis.text(shift, 1.04, f"{name}\n{strain:.3g} %", ha="center", va="bottom", size=9)
        shift += 0.5
    axis.axhline(1.0, color="#bbbbbb", lw=0.6, zorder=0)
    axis.set_xlim(-0.3, shift - 0.2)
    axis.set_ylim(-0.15, 1.32)
    axis.set_aspect("equal")
    axis.set_xticks([])
    axis.set_ylabel("height [m]")
    axis.figure.colorbar(ScalarMappable(norm, scale), ax=axis, label="strain of an edge", shrink=0.7, extend="max")
    axis.set_title("The same sheet after half a second (0.72 kg, soft membrane)", size=11)


def _cost(axis: Any, document: dict[str, Any]) -> None:
    rows = document["growth"]["vertices"]
    vertices = [row["vertices"] for row in rows]
    for solver in ("SolverAVBD", "SolverVBD"):
        taken = [1e3 * row[f"seconds_per_step_{solver}"] for row in rows]
        axis.plot(vertices, taken, "o-", color=colour(solver), label=f"{solver}, free")
        contact = document["cost"]["with_self_contact"]["lying"]
        axis.plot(
            contact["vertices"],
            1e3 * contact[f"seconds_per_step_{solver}"],
            "*",
            ms=15,
            color=colour(solver),
            mec="black",
            label=f"{solver}, two layers in contact",
        )
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel("vertices")
    axis.set_ylabel("milliseconds per substep, one core")
    free, lying = document["cost"]["without_self_contact"]["ratio"], contact["ratio"]
    axis.set_title(f"A substep at 10 iterations costs {free:.2f} of SolverVBD's, in self-contact {lying:.2f}", size=11)
    axis.grid(True, which="major", color="#dddddd")
    axis.legend(fontsize=9, loc="lower right")


def _time(axis: Any, searches: list[dict[str, Any]], pulls: list[dict[str, Any]]) -> None:
    place, ticks, names = 0.0, [], []
    for search in searches:
        rows = [search[key] for key in ("SolverAVBD", "SolverVBD") if search[key]]
        if not rows:
            continue
        held = [row for row in pulls if row["solver"].startswith("MuJoCo") and row["cloth"] == rows[0]["cloth"]]
        rows += [row for row in held if row["largest_stretch"] and row["largest_stretch"] <= search["limit"]][:1]
        best = rows[0]["seconds_per_simulated_second"]
        axis.text(0.055, place - 0.7, rows[0]["cloth"], weight="bold", size=9, va="center")
        for row in rows:
            taken = row["seconds_per_simulated_second"]
            axis.barh(place, taken, color=colour(row["solver"]), height=0.7)
            stiffer = "" if row["modulus_n_m"] == 100.0 else f"\nmoduli x {row['modulus_n_m'] / 100:.0f}"
            text = f"{taken:.2g} s" if row is rows[0] else f"{taken:.2g} s = {taken / best:.1f} x"
            axis.text(taken * 1.05, place, text, va="center", size=9)
            names.append(f"{label(row)}, {row['steps_per_s']} steps/s{stiffer}")
            ticks.append(place)
            place += 1.0
        place += 0.9
    axis.set_xscale("log")
    high = axis.get_xlim()[1]
    axis.set_xlim(0.05, max(high * 4.0, 20.0))
    axis.set_ylim(place - 0.4, -1.1)
    axis.set_yticks(ticks, names, size=9)
    axis.set_xlabel("processor seconds per simulated second")
    axis.set_title("Cheapest setting that keeps every edge below 1.06 in the pull", size=11)
