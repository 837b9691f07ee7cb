"""Air: drag of still air, a steady wind, and air carried along."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit

from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.world import State, World


@njit(nogil=True, cache=True, error_model="numpy")
def _cell_drag(x, v, wind, rows, columns, density, normal_coefficient, tangential_coefficient, boost, out):
    """Add drag (3, count) of each cell, a quarter to each corner; `boost` raises the normal coefficient at small speed.

    The coefficient of a plate that oscillates grows as the amplitude falls (Keulegan and Carpenter 1958); here it is
    c (1 + boost / (1 + (speed / 0.25 m/s)^2)).
    """
    stride = columns + 2
    a, b, n, w = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for row in range(rows - 1):
        for column in range(columns - 1):
            k = (row + 1) * stride + column + 1
            p, q, r = k + 1, k + stride, k + stride + 1
            for i in range(3):
                a[i] = 0.5 * (x[i, p] - x[i, k] + x[i, r] - x[i, q])
                b[i] = 0.5 * (x[i, q] - x[i, k] + x[i, r] - x[i, p])
                w[i] = wind[i] - 0.25 * (v[i, k] + v[i, p] + v[i, q] + v[i, r])
            for i in range(3):
                j, m = (i + 1) % 3, (i + 2) % 3
                n[i] = a[j] * b[m] - a[m] * b[j]
            area = np.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
            across = (w[0] * n[0] + w[1] * n[1] + w[2] * n[2]) / area
            along = np.sqrt(max(w[0] ** 2 + w[1] ** 2 + w[2] ** 2 - across**2, 0.0))
            press = 0.5 * density * normal_coefficient * (1 + boost / (1 + (across / 0.25) ** 2)) * abs(across) * across
            rub = 0.5 * density * tangential_coefficient * along * area
            for i in range(3):
                force = 0.25 * (press * n[i] + rub * (w[i] - across * n[i] / area))
                out[i, k] += force
                out[i, p] += force
                out[i, q] += force
                out[i, r] += force


@dataclass
class AirDrag(Effect):
    """Quadratic drag with a coefficient that is higher at small speed."""

    name: ClassVar[str] = "air_drag"
    formula: ClassVar[str] = (
        "rho/2 A (c_n (1 + 0.3 / (1 + (v_n / 0.25 m/s)^2)) |v_n| v_n n + c_t |v_t| v_t) per cell, v against the air"
    )

    def begin(self, world: World) -> None:
        """Take the grid and the air's density."""
        self._wind, self._boost = np.zeros(3), 0.3
        self._grid, self._density = world.sheet.grid, world.baseline_environment.air_density_kg_m3

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Drag on every cell."""
        values = {**self.extras, **self.parameters}
        _cell_drag(
            state.x,
            state.v,
            self._wind,
            self._grid.rows,
            self._grid.columns,
            self._density,
            values["c_normal"],
            values["c_tangential"],
            self._boost,
            out_n,
        )


@dataclass
class Wind(AirDrag):
    """A steady stream; the extras are its drag coefficients."""

    name: ClassVar[str] = "wind"
    formula: ClassVar[str] = "rho/2 A (c_n |w_n| w_n n + c_t |w_t| w_t) per cell, w = wind - cloth velocity"

    def begin(self, world: World) -> None:
        """A stream in world axes."""
        super().begin(world)
        self._wind = np.array([self.parameters[key] for key in ("vx", "vy", "vz")])
        self._boost = 0.0


@dataclass
class AddedMass(Effect):
    """Air carried along: more in the middle of the sheet than at its rim, as around a plate of finite width."""

    name: ClassVar[str] = "added_mass"
    formula: ClassVar[str] = (
        "-m(u, v) A (n . a) n, m proportional to (1 - s^2)^(1/4) with s from -1 to 1 along u and along v; `mass` is the mean"
    )

    def begin(self, world: World) -> None:
        """Lay the mass out over the sheet."""
        grid, cloth = world.sheet.grid, world.cloth
        s = 2 * grid.flat_uv_m / np.array([cloth.size_u_m, cloth.size_v_m]) - 1
        shape = np.prod(np.clip(1 - s**2, 0.0, None) ** 0.25, axis=1) * (grid.area_m2 > 0)
        self._kg = self.parameters["mass"] * grid.area_m2 * shape * (grid.area_m2.sum() / (shape * grid.area_m2).sum())

    def carried(self, state: State) -> np.ndarray | None:
        """(count,) kg."""
        return None if state.relaxing else self._kg
