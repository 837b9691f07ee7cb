"""Bending that remembers or prefers a curvature: curl, internal friction, creases, creep. Per axis u and v."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from benchmarks.concealed.bending import add_moments, curvatures
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.world import State, World


@dataclass
class Curl(Effect):
    """Moments (2, count) against curvature along u and v. A child fills `_moment` in `advance`."""

    def begin(self, world: World) -> None:
        """No moment yet."""
        sheet = world.sheet
        self._grid, self._sheet = sheet.grid, sheet
        self._size = (
            sheet.grid.rows,
            sheet.grid.columns,
            sheet.grid.du_m * sheet.scale_u,
            sheet.grid.dv_m * sheet.scale_v,
        )
        self._stiffness = np.stack([sheet.bend_u_n_m3, sheet.bend_v_n_m3])
        self._area = sheet.grid.area_m2 * (self._stiffness > 0)
        self._normal = np.zeros((3, sheet.grid.count))
        self._kappa = np.zeros((2, sheet.grid.count))
        self._moment = np.zeros((2, sheet.grid.count))

    def measure(self, state: State) -> np.ndarray:
        """(2, count) signed curvatures."""
        curvatures(state.x, *self._size, self._normal, self._kappa)
        return self._kappa

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Forces of the moments, without resultant and torque."""
        self.measure(state)
        add_moments(state.x, self._moment, *self._size, self._normal, out_n)


@dataclass
class RestCurvature(Curl):
    """The sheet without load is curled, less so towards its edges.

    What curls a cloth are stresses between its two faces, from the roll or the finish; at a free edge they can relax (as all stresses of a laminate
    do there that balance over its thickness). They fade here with the square of the distance from the middle. `kappa_u` and `kappa_v` are the mean
    over the sheet; with a `fade` of 0.25 the middle has 17 % more, an edge's middle 8 % less, a corner 33 % less.
    """

    name: ClassVar[str] = "rest_curvature"
    formula: ClassVar[str] = (
        "energy B/2 (kappa - kappa_0 f)^2 per area and axis, kappa the signed curvature at the vertex normal, "
        "f = 1 - fade (s_u^2 + s_v^2 - 2/3) with s from -1 to 1 along u and along v"
    )

    def begin(self, world: World) -> None:
        """A moment on top of the plate."""
        super().begin(world)
        rest = np.array([self.parameters["kappa_u"], self.parameters["kappa_v"]])
        s = 2 * self._grid.flat_uv_m / np.array([world.cloth.size_u_m, world.cloth.size_v_m]) - 1
        here = 1 - self.extras["fade"] * ((s**2).sum(axis=1) - 2 / 3)
        self._moment = -self._stiffness * rest[:, None] * here


@dataclass
class BendingHysteresis(Curl):
    """Threads that rub: three springs with dry sliders in parallel (Iwan 1966), of 1/2, 1/3 and 1/6 of the moment."""

    name: ClassVar[str] = "bending_hysteresis"
    formula: ClassVar[str] = (
        "sum of three spring-sliders per axis with limits moment (1/2, 1/3, 1/6) that slip after curvature changes of "
        "(1, 2, 4) times `slip_curvature`"
    )
    _share: ClassVar[np.ndarray] = np.array([1 / 2, 1 / 3, 1 / 6])
    _reach: ClassVar[np.ndarray] = np.array([1.0, 2.0, 4.0])

    def begin(self, world: World) -> None:
        """Sliders at rest in the flat sheet."""
        super().begin(world)
        self._stress = np.zeros((3, 2, self._grid.count))
        self._before = np.zeros((2, self._grid.count))

    def advance(self, state: State, step_s: float) -> None:
        """Load the springs by the change of curvature, up to the limits."""
        kappa = self.measure(state)
        limit = self.parameters["moment"] * self._share
        stiffness = limit / (self.extras["slip_curvature"] * self._reach)
        change = kappa - self._before
        self._before[:] = kappa
        for stress, most, spring in zip(self._stress, limit, stiffness):
            stress += spring * change
            np.clip(stress, -most, most, out=stress)
        self._moment = self._stress.sum(axis=0) * self._area


@dataclass
class PlasticCrease(Curl):
    """Sharp bends stay in part: plasticity with isotropic hardening."""

    name: ClassVar[str] = "plastic_crease"
    formula: ClassVar[str] = (
        "where |kappa - kappa_p| passes the yield curvature, the share `retained` of the excess goes to kappa_p and the rest "
        "raises the yield; moment B (kappa - kappa_p)"
    )

    def begin(self, world: World) -> None:
        """No crease yet."""
        super().begin(world)
        self._plastic = np.zeros((2, self._grid.count))
        self._yield = np.full((2, self._grid.count), self.parameters["yield_curvature"])

    def advance(self, state: State, step_s: float) -> None:
        """Yield where bent beyond the limit."""
        elastic = self.measure(state) - self._plastic
        excess = np.abs(elastic) - self._yield
        if (excess > 0).any():
            excess = np.maximum(excess, 0.0)
            kept = self.parameters["retained"]
            self._plastic += kept * excess * np.sign(elastic)
            self._yield += (1 - kept) * excess
            self._moment = -self._stiffness * self._plastic


@dataclass
class ViscoelasticCreep(Curl):
    """Outside the table: bending that yields slowly and comes back slowly (a standard linear solid)."""

    name: ClassVar[str] = "viscoelastic_creep"
    formula: ClassVar[str] = "moment B (kappa - c), dc/dt = (share kappa - c) / time; in equilibrium at the start"

    def begin(self, world: World) -> None:
        """Nothing crept yet."""
        super().begin(world)
        self._crept = np.zeros((2, self._grid.count))

    def advance(self, state: State, step_s: float) -> None:
        """The crept curvature goes after the curvature; fast while the cloth is brought to rest."""
        time = 0.15 if state.relaxing else self.parameters["time"]
        self._crept += (self.parameters["share"] * self.measure(state) - self._crept) * (step_s / time)
        self._moment = -self._stiffness * self._crept
