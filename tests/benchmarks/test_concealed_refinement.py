"""The laboratory's films hardly change when its steps or its mesh are refined."""

import numpy as np
import pytest

from benchmarks.concealed.cloth import Cloth, grid_of
from benchmarks.concealed.effects.patches import StiffRegion
from benchmarks.concealed.grips import hold
from benchmarks.concealed.motions import MOTIONS
from benchmarks.concealed.sheet import baseline_sheet, clamped, stable_step_s
from benchmarks.concealed.simulate import OUTER_STEP_S, Simulation, plate_step_s, steps_s
from benchmarks.concealed.table import Friction
from benchmarks.concealed.world import Environment, World

CLOTH = Cloth(0.3, 0.3, 0.2, 0.001, 400.0, 0.3, 1.5e-4, 1.5e-3)
SIDE = 12


def vertices_m(name: str, refine: int, step_scale: float = 1.0, duration_s: float = 4.0) -> np.ndarray:
    """(T, 3, SIDE^2) course of the bundle's vertices, every 10 ms."""
    grid = grid_of(CLOTH, SIDE, SIDE, refine)
    motion = MOTIONS[name](CLOTH, SIDE, SIDE, np.random.default_rng(0))
    holds = hold(motion, grid, refine, np.zeros((len(motion.blocks), 3)))
    sheet = clamped(baseline_sheet(CLOTH, grid), holds.vertices)
    room = Environment(np.array([0, 0, -9.81]), 1.2, 0.0 if motion.table else None, Friction(0.4, 0.4))
    world = World(CLOTH, motion, holds, sheet, room, sheet, room)
    course = Simulation(world, step_scale=step_scale).run(duration_s, missing=False)
    assert course.rest_speed_m_s < 5e-5
    return course.x_m[::10][:, :, [grid.at(i * refine, j * refine) for i in range(SIDE) for j in range(SIDE)]]


def rms_m(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.sqrt(((a - b) ** 2).mean()))


def test_steps_half_as_long_change_micrometres():
    coarse, fine = (vertices_m("shuttle", 1, scale, 2.0) for scale in (1.0, 0.5))
    assert rms_m(coarse, fine) < 5e-6


SOFT = Cloth(0.292, 0.25, 0.2, 0.00115, 259.0, 0.26, 2.18e-4, 1.49e-3)
"""Soft for its rigidity."""
STIFF = StiffRegion({"centre_u": 0.2, "centre_v": 0.16, "radius": 0.057, "factor": 25.0})
"""As strong as any that is drawn: bending asks for shorter steps than the membrane there."""


@pytest.mark.parametrize("damping_s", [5e-5, SOFT.damping_s])
@pytest.mark.parametrize("refine", [1, 2, 3])
@pytest.mark.parametrize("patch", [False, True])
def test_no_step_is_longer_than_the_plate_and_the_membrane_allow(patch, refine, damping_s):
    sheet = baseline_sheet(SOFT, grid_of(SOFT, SIDE, SIDE, refine))
    sheet = STIFF.sheet(sheet) if patch else sheet
    step, number = steps_s(sheet, damping_s)
    assert step <= 1.0001 * plate_step_s(sheet, damping_s)
    assert step / number <= 1.0001 * stable_step_s(sheet, damping_s)
    assert step < 1.3 * OUTER_STEP_S


def test_a_sheet_with_the_stiffest_patch_stays_finite():
    grid = grid_of(SOFT, SIDE, SIDE, 2)
    motion = MOTIONS["bar_swing"](SOFT, SIDE, SIDE, np.random.default_rng(0))
    holds = hold(motion, grid, 2, np.zeros((len(motion.blocks), 3)))
    base = clamped(baseline_sheet(SOFT, grid), holds.vertices)
    room = Environment(np.array([0, 0, -9.81]), 1.2, None, Friction(0.4, 0.4))
    course = Simulation(World(SOFT, motion, holds, STIFF.sheet(base), room, base, room), [STIFF]).run(
        0.7, missing=False
    )
    assert np.abs(np.diff(course.x_m, axis=0)).max() < 5e-3  # 5 m/s at most


@pytest.mark.slow
@pytest.mark.parametrize("name", MOTIONS)
def test_a_finer_mesh_changes_two_millimetres_at_most(name):
    """The free swings of a limp sheet are nearly chaotic; motions are chosen so that they can be foretold all the same."""
    assert rms_m(vertices_m(name, 2), vertices_m(name, 3)) < 2e-3
