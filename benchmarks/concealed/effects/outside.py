"""Effects that the format's table has no name for, beside those kept with their families."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from benchmarks.concealed.bending import vertex_normals
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.effects.patches import distance_m
from benchmarks.concealed.world import State, World


@dataclass
class FanJet(Effect):
    """A fan blows a narrow, gusty jet; it is switched on as the robot starts."""

    name: ClassVar[str] = "fan_jet"
    formula: ClassVar[str] = (
        "rho/2 A c |w_n| w_n n exp(-(r/width)^2), w = on(t) (U(t) d - v), r the distance from the jet's axis, U gusty at two rates, on from 0 to 1 between 0.55 and 0.85 s"
    )

    def begin(self, world: World) -> None:
        """Lay out the jet."""
        self._grid, self._density = world.sheet.grid, world.baseline_environment.air_density_kg_m3
        self._normal = np.zeros((3, self._grid.count))
        self._way = np.array([self.extras[key] for key in ("dx", "dy", "dz")])
        self._from = np.array([self.extras[key] for key in ("x", "y", "z")])

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Pressure of the jet on what stands in it."""
        if state.relaxing:
            return
        p, e, t = self.parameters, self.extras, state.time_s
        on = np.clip((t - 0.55) / 0.3, 0.0, 1.0)
        gust = 1 + 0.35 * np.sin(2 * np.pi * e["rate_1"] * t) + 0.25 * np.sin(2 * np.pi * e["rate_2"] * t + 1)
        vertex_normals(state.x, self._grid.rows, self._grid.columns, self._normal)
        apart = state.x - self._from[:, None]
        apart = apart - self._way[:, None] * (self._way @ apart)
        share = np.exp(-(apart**2).sum(axis=0) / e["width"] ** 2)
        across = ((p["speed"] * on * gust * self._way)[:, None] - state.v * on) * self._normal
        across = across.sum(axis=0)
        out_n += (0.5 * self._density * 1.2 * self._grid.area_m2 * share * np.abs(across) * across) * self._normal


@dataclass
class Drying(Effect):
    """A wet patch that dries during the recording: its mass falls."""

    name: ClassVar[str] = "drying"
    formula: ClassVar[str] = (
        "extra mass in a patch, mass * exp(-(t - 0.5 s) / time) from half a second on: weight and inertia"
    )

    def begin(self, world: World) -> None:
        """Wet."""
        grid, p = world.sheet.grid, self.parameters
        r = distance_m(grid, self.extras["centre_u"], self.extras["centre_v"])
        shape = np.exp(-((r / self.extras["radius"]) ** 2)) * grid.area_m2
        self._kg = p["mass"] * shape / shape.sum()
        self._weight = world.environment.gravity_m_s2[:, None] * self._kg
        self._before = None
        self._inertia = np.zeros((3, grid.count))

    def _left(self, state: State) -> float:
        return 1.0 if state.relaxing else float(np.exp(-max(state.time_s - 0.5, 0.0) / self.parameters["time"]))

    def advance(self, state: State, step_s: float) -> None:
        """Inertia of the extra mass from the velocity smoothed over 5 ms, so that it stays stable beside an explicit step."""
        if self._before is None:
            self._before = state.v.copy()
        change = (state.v - self._before) / 5e-3
        self._before += change * step_s
        self._inertia = -self._kg * change

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Weight and inertia of what is still wet."""
        left = self._left(state)
        out_n += left * self._weight
        if not state.relaxing:
            out_n += left * self._inertia


@dataclass
class HiddenThread(Effect):
    """A thread from a point of the cloth to a fixed point in the room; it pulls only when taut."""

    name: ClassVar[str] = "hidden_thread"
    formula: ClassVar[str] = (
        "stiffness * (length - slack_length) along the thread where positive, spread over 15 mm of cloth"
    )

    def begin(self, world: World) -> None:
        """Tie it."""
        grid, p = world.sheet.grid, self.parameters
        r = distance_m(grid, self.extras["centre_u"], self.extras["centre_v"])
        self._share = np.exp(-((r / 0.015) ** 2)) * grid.area_m2
        self._share /= self._share.sum()
        self._post = np.array([self.extras[key] for key in ("x", "y", "z")])
        self._stiffness, self._slack, self._taut_at = p["stiffness"], self.extras.get("slack_length", -1.0), None

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Pull where taut; without a given length the thread is just straight in the cloth's place at rest."""
        way = self._post - state.x @ self._share
        length = float(np.linalg.norm(way))
        if state.relaxing:
            self._taut_at = length * 1.001
            return
        slack = self._slack if self._slack > 0 else self._taut_at
        if length > slack:
            out_n += (self._stiffness * (length - slack) / length * way)[:, None] * self._share


@dataclass
class Magnet(Effect):
    """A magnet in the room pulls at a small piece of steel in the cloth, which weighs nothing to speak of."""

    name: ClassVar[str] = "magnet"
    formula: ClassVar[str] = "strength * d / (|d|^2 + core^2)^2, d from the piece to the magnet"

    def begin(self, world: World) -> None:
        """Sew it in."""
        grid = world.sheet.grid
        r = distance_m(grid, self.extras["centre_u"], self.extras["centre_v"])
        self._share = np.exp(-((r / 0.02) ** 2)) * grid.area_m2
        self._share /= self._share.sum()
        self._magnet = np.array([self.extras[key] for key in ("x", "y", "z")])

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Pull."""
        way = self._magnet - state.x @ self._share
        out_n += (self.parameters["strength"] * way / (way @ way + self.extras["core"] ** 2) ** 2)[
            :, None
        ] * self._share


@dataclass
class StaticCharge(Effect):
    """A charged cloth is repelled by (or drawn to) a charged rod that stands in the room."""

    name: ClassVar[str] = "static_charge"
    formula: ClassVar[str] = "per area: strength * d / (|d|^2 + core^2), d from a vertical line to the vertex"

    def begin(self, world: World) -> None:
        """Where the rod stands."""
        self._rod = np.array([self.extras["x"], self.extras["y"]])
        self._area = world.sheet.grid.area_m2

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Push away from the rod."""
        away = state.x[:2] - self._rod[:, None]
        out_n[:2] += (
            self.parameters["strength"] * self._area * away / ((away**2).sum(axis=0) + self.extras["core"] ** 2)
        )
