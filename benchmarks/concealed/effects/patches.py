"""Round patches: one that is stiffer, one that is heavier."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from benchmarks.concealed.cloth import Grid
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.sheet import Sheet


def distance_m(grid: Grid, centre_u: float, centre_v: float) -> np.ndarray:
    """(count,) material distance of the vertices from a point."""
    return np.linalg.norm(grid.flat_uv_m - np.array([centre_u, centre_v]), axis=1)


@dataclass
class StiffRegion(Effect):
    """A patch that bends less, with a soft rim a fifth of its radius wide."""

    name: ClassVar[str] = "stiff_region"
    formula: ClassVar[str] = "B (1 + (factor - 1) / (1 + exp((r - radius) / (radius / 10))))"

    def sheet(self, sheet: Sheet) -> Sheet:
        """More bending stiffness around the centre."""
        p = self.parameters
        r = distance_m(sheet.grid, p["centre_u"], p["centre_v"])
        more = 1 + (p["factor"] - 1) / (1 + np.exp(np.clip((r - p["radius"]) / (p["radius"] / 10), -50, 50)))
        return replace(
            sheet,
            bend_u_n_m3=sheet.bend_u_n_m3 * more,
            bend_v_n_m3=sheet.bend_v_n_m3 * more,
            twist_n_m3=sheet.twist_n_m3 * more,
        )


@dataclass
class HeavyRegion(Effect):
    """A wet patch: more mass, most of it in the middle."""

    name: ClassVar[str] = "heavy_region"
    formula: ClassVar[str] = (
        "extra mass per area proportional to cos^2(pi r / (2 radius)) within the radius, `mass` in all"
    )

    def sheet(self, sheet: Sheet) -> Sheet:
        """More mass around the centre."""
        p = self.parameters
        r = distance_m(sheet.grid, p["centre_u"], p["centre_v"])
        shape = np.where(r < self.extras["radius"], np.cos(np.pi * r / (2 * self.extras["radius"])) ** 2, 0.0)
        shape *= sheet.grid.area_m2
        return replace(sheet, mass_kg=sheet.mass_kg + p["mass"] * shape / shape.sum())
