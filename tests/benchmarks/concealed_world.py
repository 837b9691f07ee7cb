"""A small virtual sheet and its states, for tests of what is concealed in it."""

import numpy as np

from benchmarks.concealed.case import Plan
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.film import Stage, grid_for
from benchmarks.concealed.markers import draw_markers
from benchmarks.concealed.motions import MOTIONS
from benchmarks.concealed.setting import draw_setting
from benchmarks.concealed.sheet import baseline_sheet
from benchmarks.concealed.table import Friction
from benchmarks.concealed.world import Environment, State, World


def world_of(effect: Effect | None = None, motion: str = "swing_out", table: bool = False) -> World:
    setting = draw_setting(np.random.default_rng(4))
    grid = grid_for(setting)
    stage = Stage(setting, grid, draw_markers(setting, grid, np.random.default_rng(0)), {})
    made = MOTIONS[motion](setting.cloth, setting.columns, setting.rows, np.random.default_rng(0))
    stage.offsets_m.update({block.drive: np.zeros(3) for block in made.blocks})
    base = baseline_sheet(setting.cloth, grid)
    room = Environment(np.array([0.0, 0.0, -9.81]), 1.2, 0.0 if table else None, Friction(0.4, 0.4))
    sheet = effect.sheet(base) if effect else base
    here = effect.environment(room) if effect else room
    return World(setting.cloth, made, stage.holds(Plan("a", made, True, False)), sheet, here, base, room)


def flat(world: World) -> State:
    grid = world.sheet.grid
    x = np.zeros((3, grid.count))
    x[:2, grid.inside] = grid.uv_m.T
    state = State(x, np.zeros_like(x), len(world.holds.offsets_m))
    state.relaxing = False
    return state


def moving(world: World, velocity) -> State:
    state = flat(world)
    state.v[:, world.sheet.grid.inside] = np.array(velocity)[:, None]
    return state


def rolled(world: World, kappa: float, axis: int) -> State:
    """A cylinder of that curvature, towards the normal u x v."""
    state, grid = flat(world), world.sheet.grid
    s = grid.flat_uv_m[:, axis]
    bent = np.stack([np.sin(kappa * s) / kappa, (1 - np.cos(kappa * s)) / kappa])
    state.x[axis, grid.inside], state.x[2, grid.inside] = bent[:, grid.inside]
    return state


def force(effect: Effect, world: World, state: State) -> np.ndarray:
    out = np.zeros_like(state.x)
    effect.add_force(state, out)
    return out
