"""Air: drag of still air, a gusty wind, and air carried along."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numba import njit

from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.motions.motion import DURATION_S
from benchmarks.concealed.world import State, World

GUSTS_FROM_S = 0.5


@njit(nogil=True, cache=True, error_model="numpy")
def _cell_drag(x, v, wind, profile, rows, columns, density, normal_coefficient, tangential_coefficient, boost, out):
    """Add drag (3, count) of each cell, a quarter to each corner; `boost` raises the normal coefficient at small speed.

    The coefficient of a plate that oscillates grows as the amplitude falls (Keulegan and Carpenter 1958); here it is
    c (1 + boost / (1 + (speed / 0.25 m/s)^2)) / (1 + boost / 2), which is c at 0.25 m/s. The wind goes with the height to the power of `profile`, and is `wind` at 0.65 m.
    """
    stride = columns + 2
    a, b, n, w = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    for row in range(rows - 1):
        for column in range(columns - 1):
            k = (row + 1) * stride + column + 1
            p, q, r = k + 1, k + stride, k + stride + 1
            blown = 1.0
            if profile > 0.0:
                blown = (max(0.25 * (x[2, k] + x[2, p] + x[2, q] + x[2, r]), 0.005) / 0.65) ** profile
            for i in range(3):
                a[i] = 0.5 * (x[i, p] - x[i, k] + x[i, r] - x[i, q])
                b[i] = 0.5 * (x[i, q] - x[i, k] + x[i, r] - x[i, p])
                w[i] = blown * wind[i] - 0.25 * (v[i, k] + v[i, p] + v[i, q] + v[i, r])
            for i in range(3):
                j, m = (i + 1) % 3, (i + 2) % 3
                n[i] = a[j] * b[m] - a[m] * b[j]
            area = np.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
            across = (w[0] * n[0] + w[1] * n[1] + w[2] * n[2]) / area
            along = np.sqrt(max(w[0] ** 2 + w[1] ** 2 + w[2] ** 2 - across**2, 0.0))
            grown = (1 + boost / (1 + (across / 0.25) ** 2)) / (1 + boost / 2)
            press = 0.5 * density * normal_coefficient * grown * abs(across) * across
            rub = 0.5 * density * tangential_coefficient * along * area
            for i in range(3):
                force = 0.25 * (press * n[i] + rub * (w[i] - across * n[i] / area))
                out[i, k] += force
                out[i, p] += force
                out[i, q] += force
                out[i, r] += force


@dataclass
class AirDrag(Effect):
    """Quadratic drag with a coefficient that is higher at small speed; `c_normal` is that at 0.25 m/s."""

    name: ClassVar[str] = "air_drag"
    formula: ClassVar[str] = (
        "rho/2 A (c_n (1 + 0.3 / (1 + (v_n / 0.25 m/s)^2)) / 1.15 |v_n| v_n n + c_t |v_t| v_t) per cell, v against the air"
    )

    def begin(self, world: World) -> None:
        """Take the grid and the air's density."""
        self._wind, self._boost, self._profile = np.zeros(3), 0.3, 0.0
        self._grid, self._density = world.sheet.grid, world.baseline_environment.air_density_kg_m3

    def _blow(self, state: State) -> np.ndarray:
        """(3,) m/s, the stream in the middle of a sheet that hangs."""
        return self._wind

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Drag on every cell."""
        values = {**self.extras, **self.parameters}
        _cell_drag(
            state.x,
            state.v,
            self._blow(state),
            self._profile,
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
    """A stream with mild gusts, faster higher up; the extras are its drag coefficients, its gusts and its profile.

    Prandtl's seventh-root law over the table's height, and two waves of gusts, which have run a whole number of times when the recording ends. Air in
    ventilated rooms is gustier: ISO 7730 takes a turbulence intensity of 40 % where none is measured, here it is 5 to 10 %. `vx`, `vy`, `vz` are the mean
    over a recording at 0.65 m, the middle of a sheet that hangs, whose edges feel 3 to 4 % more and less. As drag is quadratic, its mean is up to 1 %
    above that of the mean wind. It blows steadily until the gusts begin, so that the sheet rests for half a second, as recordings promise.
    """

    name: ClassVar[str] = "wind"
    formula: ClassVar[str] = (
        "rho/2 A (c_n |w_n| w_n n + c_t |w_t| w_t) per cell, w = wind U(t) (z / 0.65 m)^profile - cloth velocity, from 0.5 s on "
        "U = 1 + gust (sin(2 pi waves_1 s) + 0.6 sin(2 pi waves_2 s)) with s from 0 to 1 at the end"
    )

    def begin(self, world: World) -> None:
        """A stream in world axes."""
        super().begin(world)
        self._wind = np.array([self.parameters[key] for key in ("vx", "vy", "vz")])
        self._boost, self._profile = 0.0, self.extras["profile"]

    def _blow(self, state: State) -> np.ndarray:
        e, s = self.extras, 2 * np.pi * max(state.time_s - GUSTS_FROM_S, 0.0) / (DURATION_S - GUSTS_FROM_S)
        return self._wind * (1 + e["gust"] * (np.sin(e["waves_1"] * s) + 0.6 * np.sin(e["waves_2"] * s)))


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
