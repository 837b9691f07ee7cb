"""One recording of a world: the markers' course, with and without the effects, and where the effects push."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.concealed.case import Plan
from benchmarks.concealed.cloth import Grid, grid_of
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.grips import Holds, Poses, commanded, hold
from benchmarks.concealed.markers import Markers, cubic_weights
from benchmarks.concealed.motions.motion import DURATION_S
from benchmarks.concealed.motions.tabletop import TABLE_M
from benchmarks.concealed.setting import REFINE, Setting
from benchmarks.concealed.sheet import baseline_sheet, clamped
from benchmarks.concealed.simulate import Course, Simulation
from benchmarks.concealed.table import Friction
from benchmarks.concealed.world import Environment, World

AFTER_S = 0.25
"""Simulated beyond the recording, for clocks that are off."""


@dataclass(frozen=True)
class Track:
    """The true course of M markers at even times (T,)."""

    times_s: np.ndarray
    places_m: np.ndarray
    """(T, M, 3)"""
    missing_n_m2: np.ndarray
    """(T, M) size of the force per area that the baseline lacks."""
    grip_shift_m: np.ndarray
    """(T, M) how far the nearest held vertices are off, fading with the material distance."""
    grip_load_n: np.ndarray
    """(T, D, 3) force of the cloth on each gripper."""
    rest_speed_m_s: float
    nearest_m: float
    """Smallest distance in space of two vertices that are far apart in the cloth."""

    def sample(self, times_s: np.ndarray) -> np.ndarray:
        """(F, M, 3) places at times (F, M); before the start and after the end the cloth stays as it is there."""
        step = self.times_s[1] - self.times_s[0]
        place = np.clip(times_s / step, 0, len(self.times_s) - 1.000001)
        before = place.astype(int)
        share = (place - before)[..., None]
        marker = np.arange(self.places_m.shape[1])
        return (1 - share) * self.places_m[before, marker] + share * self.places_m[before + 1, marker]


@dataclass(frozen=True)
class Stage:
    """What all recordings of a bundle share."""

    setting: Setting
    grid: Grid
    markers: Markers
    offsets_m: dict[str, np.ndarray]
    """(3,) per drive: from the robot's own point to the middle of the held cloth, in the drive's frame."""

    @property
    def refine(self) -> int:
        """The grid against the bundle's mesh, per side."""
        return (self.grid.columns - 1) // (self.setting.columns - 1)

    @property
    def spacing_m(self) -> tuple[float, float]:
        """Of the bundle's mesh, along u and v."""
        return self.refine * self.grid.du_m, self.refine * self.grid.dv_m

    def holds(self, plan: Plan) -> Holds:
        """Held vertices of one recording."""
        offsets = np.stack([self.offsets_m[block.drive] for block in plan.motion.blocks])
        return hold(plan.motion, self.grid, self.refine, offsets)

    def coarser(self) -> "Stage":
        """The same on the bundle's own mesh: several times as fast."""
        setting = self.setting
        grid = grid_of(setting.cloth, setting.columns, setting.rows, 1)
        return replace(self, grid=grid, markers=replace(self.markers, weights=cubic_weights(grid, self.markers.uv_m)))

    def command(self, plan: Plan, times_s: np.ndarray) -> Poses:
        """What the robot is told."""
        return commanded(plan.motion, self.holds(plan), times_s)


def grid_for(setting: Setting) -> Grid:
    """The laboratory's grid."""
    return grid_of(setting.cloth, setting.columns, setting.rows, REFINE)


def film(stage: Stage, plan: Plan, effects: Sequence[Effect], duration_s: float = DURATION_S + AFTER_S) -> Track:
    """Simulate one recording."""
    setting, holds = stage.setting, stage.holds(plan)
    baseline = clamped(baseline_sheet(setting.cloth, stage.grid), holds.vertices)
    friction = Friction(setting.friction, setting.friction)
    room = Environment(
        np.array([0.0, 0.0, -9.81]), setting.air_density_kg_m3, TABLE_M if plan.motion.table else None, friction
    )
    sheet, environment = baseline, room
    for effect in effects:
        sheet, environment = effect.sheet(sheet), effect.environment(environment)
    world = World(setting.cloth, plan.motion, holds, sheet, environment, baseline, room)
    course = Simulation(world, effects).run(duration_s, missing=bool(effects))
    return _track(stage, holds, course)


def _track(stage: Stage, holds: Holds, course: Course) -> Track:
    grid, markers = stage.grid, stage.markers
    places = np.einsum("mk,tik->tmi", markers.weights, course.x_m, optimize=True)
    area = np.where(grid.area_m2 > 0, grid.area_m2, 1)
    near = nearby(grid, markers.uv_m, stage.spacing_m[0])
    if len(course.missing_n):
        density = np.linalg.norm(np.einsum("mk,tik->tmi", near, course.missing_n / area, optimize=True), axis=2)
    else:
        density = np.zeros(places.shape[:2])
    apart = np.linalg.norm(markers.uv_m[:, None] - grid.flat_uv_m[holds.vertices], axis=2)
    fade = np.exp(-((apart / (3 * stage.spacing_m[0])) ** 2))
    shift = (np.linalg.norm(course.grip_shift_m, axis=2)[:, None] * fade).max(axis=2)
    return Track(
        course.times_s,
        places,
        density,
        shift,
        course.grip_load_n,
        course.rest_speed_m_s,
        nearest_m(grid, course.x_m[::50], max(stage.spacing_m)),
    )


def nearby(grid: Grid, uv_m: np.ndarray, width_m: float) -> np.ndarray:
    """(M, count) shares of the vertices around each marker, Gaussian."""
    apart = np.linalg.norm(uv_m[:, None] - grid.flat_uv_m, axis=2)
    share = np.exp(-((apart / width_m) ** 2)) * grid.area_m2
    return share / share.sum(axis=1, keepdims=True)


def nearest_m(grid: Grid, x_m: np.ndarray, spacing_m: float) -> float:
    """Smallest distance of vertices that are three spacings or more apart in the cloth."""
    reach = 3 * spacing_m
    smallest = reach
    for x in x_m[:, :, grid.inside]:
        pairs = cKDTree(x.T).query_pairs(smallest, output_type="ndarray")
        far = np.linalg.norm(grid.uv_m[pairs[:, 0]] - grid.uv_m[pairs[:, 1]], axis=1) >= reach * 1.001
        if far.any():
            apart = x[:, pairs[far, 0]] - x[:, pairs[far, 1]]
            smallest = min(smallest, float(np.linalg.norm(apart, axis=0).min()))
    return smallest
