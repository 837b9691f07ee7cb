"""The laboratory's films hardly change when its steps or its mesh are refined."""

import numpy as np
import pytest

from benchmarks.concealed.cloth import Cloth, grid_of
from benchmarks.concealed.grips import hold
from benchmarks.concealed.motions import MOTIONS
from benchmarks.concealed.sheet import baseline_sheet, clamped
from benchmarks.concealed.simulate import Simulation
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


@pytest.mark.slow
@pytest.mark.parametrize("name", MOTIONS)
def test_a_finer_mesh_changes_two_millimetres_at_most(name):
    """The free swings of a limp sheet are nearly chaotic; motions are chosen so that they can be foretold all the same."""
    assert rms_m(vertices_m(name, 2), vertices_m(name, 3)) < 2e-3
