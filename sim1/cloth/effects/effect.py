"""What an effect is to the solver and to the search for missing physics."""

import math
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any, ClassVar

import numpy as np

from sim1.cloth.effects.coefficient import Coefficient
from sim1.cloth.precise.world import World


@dataclass(frozen=True, kw_only=True)
class Site:
    """What a search knows of the recordings when it chooses where effects could act."""

    low_m: tuple[float, float]  # of the material coordinates
    high_m: tuple[float, float]
    curvature_1_m: float  # largest that the baseline reaches, in most places
    grip_load_n: float  # the sheet's weight on each grip
    table: bool

    @property
    def width_m(self) -> float:
        """The shorter side."""
        return min(self.high_m[0] - self.low_m[0], self.high_m[1] - self.low_m[1])

    def grid(self, count: int) -> list[tuple[float, float]]:
        """Centres of count x count cells."""
        share = (np.arange(count) + 0.5) / count
        (u0, v0), (u1, v1) = self.low_m, self.high_m
        return [(float(u0 + a * (u1 - u0)), float(v0 + b * (v1 - v0))) for b in share for a in share]


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One physical effect: its parameters as a model file holds them, how to search for it, and how simulators act it.

    The identification simulator asks `alter`; `SolverAVBD` calls `shape` and `push`.
    """

    name: ClassVar[str]
    signature: ClassVar[str]  # how it shows in a recording, one line for reports
    source: ClassVar[str]  # of the formula
    typical: ClassVar[str]  # range that is met
    varied: ClassVar[str]  # how to repeat a motion so that it shows otherwise than what imitates it
    testing: ClassVar[str | None] = (
        None  # the recording that tells it from physics that no effect is, where there is such
    )
    coefficients: ClassVar[tuple[Coefficient, ...]]  # what a search varies; the strengths first
    limits: ClassVar[dict[str, tuple[float, float]]] = {}  # of parameters that are no coefficients
    fixed: ClassVar[dict[str, str]] = {}  # parameters that no search varies, and their units
    on_table: ClassVar[bool] = False  # acts through the table alone
    beyond: ClassVar[bool] = False  # acts above a threshold alone, and `variants` are thresholds
    afar: ClassVar[tuple[dict[str, float], ...]] = ()  # coefficients far from nothing, from which it is sought as well
    widens: ClassVar[str | None] = None  # name of the effect that this one is where its shapes are 0
    delays: ClassVar[bool] = False  # makes markers come late, as is measured without simulating
    measured: ClassVar[bool] = False  # belongs to the rig or to the cameras, not to the cloth
    rank: ClassVar[int] = 0  # shapes and pushes before those of lower rank, which build on what it leaves
    warp: ClassVar[tuple[float, float, float] | None] = None  # direction of the warp threads at rest, where it says so

    def __post_init__(self) -> None:
        """Refuse what cannot be meant, or would divide by nothing.

        Raises:
            ValueError: a parameter that is not finite, or outside of the limits of its coefficient.
        """
        limits = self.allowed()
        for field in fields(self):
            value = getattr(self, field.name)
            low, high = limits.get(field.name, (-math.inf, math.inf))
            numbers = value if isinstance(value, (tuple, list)) else (value,)
            if not all(isinstance(n, Real) and math.isfinite(n) and low <= n <= high for n in numbers):
                raise ValueError(
                    f"{self.name}: {field.name} is {value!r}, must be finite and between {low:g} and {high:g}"
                )

    @classmethod
    def allowed(cls) -> dict[str, tuple[float, float]]:
        """Least and largest value of coefficients and parameters."""
        return {c.name: (c.low, c.high) for c in cls.coefficients} | cls.limits

    @classmethod
    def alter(cls, world: World, values: dict[str, float]) -> World:
        """The world with this effect; `values` by name of coefficient."""
        raise NotImplementedError

    @classmethod
    def variants(cls, site: Site) -> list[dict[str, float]]:
        """Places, thresholds or directions from which a search starts: values of the shape coefficients."""
        del site
        return [{}]

    @classmethod
    def relieves(cls, world: World, values: dict[str, float]) -> dict[str, float]:
        """What is left of coefficients of the fabric that do nearly all of this effect's work where it is missing.

        By name, as shares (1) of what they are in `world`; empty for an effect that hides in none. `values`: by name of its coefficients.
        """
        del world, values
        return {}

    @classmethod
    def published(cls, world: World, values: dict[str, float]) -> dict[str, float]:
        """Parameters, as a model file holds them, from the coefficients of a search."""
        del world
        return {c.name: values[c.name] for c in cls.coefficients}

    @classmethod
    def searched(cls, parameters: dict[str, float]) -> dict[str, float]:
        """The inverse of `published`: coefficients of a search from parameters of a model file; what is not among them is left out."""
        return {c.name: parameters[c.name] for c in cls.coefficients if c.name in parameters}

    @classmethod
    def units(cls) -> dict[str, str]:
        """Unit of each parameter of a model file."""
        return {c.name: c.unit for c in cls.coefficients}

    def act(self, world: World) -> World:
        """The world with this effect at its parameters."""
        return self.alter(world, self.searched({field.name: getattr(self, field.name) for field in fields(self)}))

    def shape(self, solver: Any) -> None:
        """Change the arrays of `solver.sheet`, once, when the solver is made or the model changed; by falling `rank`."""

    def push(self, solver: Any, dt: float) -> None:
        """Act on a step before its sweeps; by falling `rank`.

        On vertices by adding to `solver.now.force` and `solver.now.slope`, on hinges by `solver.curving.answer`, which shifts
        `solver.sheet.hinge_angle` for the step, on contacts by changing `solver.solids.friction` and `solver.solids.skew`.
        """
