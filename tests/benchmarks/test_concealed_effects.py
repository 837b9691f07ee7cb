"""Each concealed effect does what its formula says."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks.concealed.bending import Plate
from benchmarks.concealed.case import Plan
from benchmarks.concealed.effects.air import AddedMass, AirDrag, Wind
from benchmarks.concealed.effects.curl import BendingHysteresis, PlasticCrease, RestCurvature, ViscoelasticCreep
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.effects.elastic import AnisotropicBending, AnisotropicStretch, Shrinkage, StrainStiffening
from benchmarks.concealed.effects.measurement import GravityTilt
from benchmarks.concealed.effects.outside import Drying, FanJet, HiddenThread, Magnet, StaticCharge
from benchmarks.concealed.effects.patches import HeavyRegion, StiffRegion
from benchmarks.concealed.effects.robot import ActuatorLag, GripCompliance, GripperVibration, GripSlip
from benchmarks.concealed.effects.tabletop import Adhesion
from benchmarks.concealed.film import Stage, grid_for
from benchmarks.concealed.grips import Poses
from benchmarks.concealed.markers import draw_markers
from benchmarks.concealed.membrane import Membrane
from benchmarks.concealed.motions import MOTIONS
from benchmarks.concealed.setting import draw_setting
from benchmarks.concealed.sheet import baseline_sheet
from benchmarks.concealed.simulate import Gap
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


def test_drag_is_quadratic_against_the_motion_and_wind_is_drag_of_a_resting_sheet():
    drag = AirDrag({"c_normal": 1.0, "c_tangential": 0.1})
    world = world_of(drag)
    drag.begin(world)
    area = world.sheet.grid.area_m2.sum()
    fast = force(drag, world, moving(world, (0, 0, 2.0))).sum(axis=1)
    assert fast == pytest.approx([0, 0, -0.5 * 1.2 * area * 4 * (1 + 0.3 / 65)], rel=1e-9)
    along = force(drag, world, moving(world, (1.0, 0, 0))).sum(axis=1)
    assert along == pytest.approx([-0.5 * 1.2 * area * 0.1, 0, 0], rel=1e-9)
    wind = Wind({"vx": 0.0, "vy": 0.0, "vz": 3.0}, {"c_normal": 1.0, "c_tangential": 0.1})
    wind.begin(world)
    assert force(wind, world, flat(world))[2].sum() == pytest.approx(0.5 * 1.2 * area * 9, rel=1e-9)
    assert np.abs(force(wind, world, moving(world, (0, 0, 3.0)))).max() < 1e-12


def test_added_mass_has_its_mean_and_acts_along_the_normal_only():
    effect = AddedMass({"mass": 0.1})
    world = world_of(effect)
    effect.begin(world)
    kg = effect.carried(flat(world))
    assert kg.sum() == pytest.approx(0.1 * world.sheet.grid.area_m2.sum())
    acceleration = np.zeros_like(flat(world).x)
    acceleration[0], acceleration[2] = 5.0, 2.0
    missing = Gap(world, [effect]).force(flat(world), acceleration)
    assert missing[2] == pytest.approx(-2.0 * kg)
    assert np.abs(missing[:2]).max() < 1e-12


def test_anisotropy_keeps_the_geometric_mean():
    base = world_of().sheet
    stretch = AnisotropicStretch({"ratio_warp_weft": 4.0}).sheet(base)
    bending = AnisotropicBending({"ratio_warp_weft": 4.0}).sheet(base)
    cell, vertex = base.grid.at(3, 3), base.grid.at(5, 5)
    assert stretch.uu_j[cell] / stretch.vv_j[cell] == pytest.approx(4)
    assert stretch.uu_j[cell] * stretch.vv_j[cell] == pytest.approx(base.uu_j[cell] ** 2)
    assert bending.bend_u_n_m3[vertex] / bending.bend_v_n_m3[vertex] == pytest.approx(4)


def test_stiffening_raises_the_stress_of_a_stretched_sheet_only():
    base = world_of().sheet
    none = np.zeros(0, dtype=int)
    sheets = [Membrane(sheet, none) for sheet in (base, StrainStiffening({"growth": 20.0}).sheet(base))]
    for stretch, factor in ((1.02, 1 + 20 * (1.02**2 - 1) / 2), (0.99, 1.0)):
        state = flat(world_of())
        state.x[0] *= stretch
        edge = base.grid.at(5, 0)
        soft, stiff = (membrane.forces(state.x, state.v)[0, edge] for membrane in sheets)
        assert stiff / soft == pytest.approx(factor, rel=1e-6)


def test_a_shrunken_sheet_is_at_rest_at_its_new_size_with_the_old_mass():
    base = world_of().sheet
    sheet = Shrinkage({"scale_u": 0.98, "scale_v": 0.97}).sheet(base)
    state = flat(world_of())
    state.x[0] *= 0.98
    state.x[1] *= 0.97
    assert np.abs(Membrane(sheet, np.zeros(0, dtype=int)).forces(state.x, state.v)).max() < 1e-10
    assert sheet.mass_kg.sum() == base.mass_kg.sum()


def test_patches_have_their_mass_place_and_factor():
    base = world_of().sheet
    heavy = HeavyRegion({"centre_u": 0.1, "centre_v": 0.15, "mass": 0.004}, {"radius": 0.04}).sheet(base)
    more = heavy.mass_kg - base.mass_kg
    assert more.sum() == pytest.approx(0.004)
    assert (more @ base.grid.flat_uv_m) / 0.004 == pytest.approx([0.1, 0.15], abs=0.002)
    stiff = StiffRegion({"centre_u": 0.1, "centre_v": 0.15, "radius": 0.06, "factor": 5.0}).sheet(base)
    ratio = stiff.twist_n_m3[base.grid.is_cell] / base.twist_n_m3[base.grid.is_cell]
    assert ratio.max() == pytest.approx(5.0, rel=0.01)
    assert ratio.min() == pytest.approx(1.0, abs=1e-6)
    inside = np.linalg.norm(base.grid.flat_uv_m[base.grid.is_cell] - [0.1, 0.15], axis=1) < 0.06
    assert (ratio[inside] > 2.9).all()


@pytest.mark.parametrize("axis", [0, 1])
def test_a_curled_sheet_is_at_rest_at_its_curvature(axis):
    effect = RestCurvature({"kappa_u": 5.0 * (axis == 0), "kappa_v": 5.0 * (axis == 1)})
    world = world_of(effect)
    effect.begin(world)
    grid = world.sheet.grid
    net = grid.inside.reshape(grid.rows, grid.columns)[3:-3, 3:-3]
    gap = Gap(world, [effect])
    start = force(effect, world, flat(world))
    assert np.abs(start[2]).max() > 1e-5
    pulls = {}
    for kappa in (5.0, -5.0):
        state = rolled(world, kappa, axis)
        bent = np.zeros_like(state.x)
        Plate(world.sheet).add(state.x, state.v, bent)
        rim = grid.at(0, 5) if axis == 1 else grid.at(5, 0)
        pulls[kappa] = np.linalg.norm((bent + gap.force(state, state.v))[:, rim])
        assert np.abs(bent[:, net]).max() < 0.02 * pulls[kappa] or kappa > 0
    assert pulls[5.0] < 0.02 * pulls[-5.0]


def test_hysteresis_reaches_its_moment_and_loses_energy_in_a_cycle():
    effect = BendingHysteresis({"moment": 1e-3}, {"slip_curvature": 1.0})
    world = world_of(effect)
    effect.begin(world)
    k = world.sheet.grid.at(8, 8)
    course = 10 * np.sin(np.linspace(0, 4 * np.pi, 400))
    moments = []
    for kappa in course:
        effect.advance(rolled(world, kappa if kappa else 1e-6, 0), 1e-4)
        moments.append(effect._moment[0, k] / world.sheet.grid.area_m2[k])
    moments = np.array(moments)
    assert np.abs(moments).max() == pytest.approx(1e-3, rel=1e-6)
    loss = np.sum(0.5 * (moments[201:] + moments[200:-1]) * np.diff(course[200:]))
    assert 0.6 * 4 * 10 * 1e-3 < loss < 4 * 10 * 1e-3


def test_a_crease_keeps_its_share_of_what_went_beyond_the_yield():
    effect = PlasticCrease({"yield_curvature": 8.0, "retained": 0.5})
    world = world_of(effect)
    effect.begin(world)
    k = world.sheet.grid.at(8, 8)
    for kappa in (*np.linspace(0.1, 20, 60), *np.linspace(20, 0.1, 60)):
        effect.advance(rolled(world, kappa, 1), 1e-4)
    assert effect._plastic[1, k] == pytest.approx(0.5 * (20 - 8), rel=0.02)
    assert effect._plastic[0, k] == pytest.approx(0.0, abs=1e-9)


def test_creep_goes_after_the_curvature():
    effect = ViscoelasticCreep({"share": 0.4, "time": 0.5})
    world = world_of(effect)
    effect.begin(world)
    for _ in range(100):
        effect.advance(rolled(world, 10.0, 0), 0.005)
    k = world.sheet.grid.at(8, 8)
    assert effect._crept[0, k] == pytest.approx(4.0 * (1 - np.exp(-1)), rel=0.02)


def test_adhesion_pulls_what_is_near_the_table():
    effect = Adhesion({"pressure": 2.0}, {"reach": 0.0015})
    world = world_of(effect, "lift_off", table=True)
    effect.begin(world)
    state = flat(world)
    state.x[2] = world.cloth.thickness_m / 2
    area = world.sheet.grid.area_m2.sum()
    assert force(effect, world, state)[2].sum() == pytest.approx(-2.0 * area)
    state.x[2] += 0.002
    assert np.abs(force(effect, world, state)).max() == 0


def test_lag_follows_a_ramp_by_its_time_and_a_turn_too():
    times = np.arange(0, 2, 1e-3)
    turn = Rotation.from_rotvec(np.outer(0.3 * times, [0, 0, 1.0])).as_matrix()[:, None]
    told = Poses(np.stack([times, 0 * times, 0 * times], axis=1)[:, None], turn)
    true = ActuatorLag({"time_constant": 0.05}).poses(times, told)
    assert told.position_m[-1, 0, 0] - true.position_m[-1, 0, 0] == pytest.approx(0.05, rel=1e-3)
    angle = Rotation.from_matrix(true.rotation[-1, 0]).magnitude()
    assert 0.3 * times[-1] - angle == pytest.approx(0.015, rel=1e-3)


def test_grips_slip_for_good_above_the_threshold_and_yield_elastically():
    slip, give = GripSlip({"threshold": 0.2, "rate": 0.01}), GripCompliance({"stiffness": 100.0}, {"jaw_mass": 0.02})
    world = world_of(slip)
    state = flat(world)
    for effect in (slip, give):
        effect.begin(world)
    for load in (0.1, 1.2, 0.0):
        state.grip_load_n[:] = (load, 0, 0)
        for _ in range(1000):
            slip.advance(state, 1e-3)
            give.advance(state, 1e-3)
        if load == 1.2:
            assert give.grip_shift(state)[:, 0] == pytest.approx(0.012, rel=1e-3)
    assert slip.grip_shift(state)[:, 0] == pytest.approx(0.01)
    assert give.grip_shift(state)[:, 0] == pytest.approx(0.0, abs=1e-5)


def test_gravity_tilts_as_the_format_says():
    gravity = world_of(GravityTilt({"tilt_x": 0.1, "tilt_y": 0.0})).environment.gravity_m_s2
    assert gravity == pytest.approx([0, 9.81 * np.sin(0.1), -9.81 * np.cos(0.1)])
    gravity = world_of(GravityTilt({"tilt_x": 0.0, "tilt_y": 0.1})).environment.gravity_m_s2
    assert gravity == pytest.approx([-9.81 * np.sin(0.1), 0, -9.81 * np.cos(0.1)])


def test_effects_outside_the_table_push_where_they_should():
    world = world_of()
    here = {"centre_u": 0.1, "centre_v": 0.1, "x": 0.1, "y": 0.1, "z": 0.2}
    state = flat(world)
    magnet = Magnet({"strength": 1e-5}, {**here, "core": 0.03})
    magnet.begin(world)
    pull = force(magnet, world, state).sum(axis=1)
    assert pull[2] == pytest.approx(1e-5 * 0.2 / (0.04 + 0.0009) ** 2, rel=0.01)
    thread = HiddenThread({"stiffness": 2.0}, {**here, "slack_length": 0.15})
    thread.begin(world)
    assert force(thread, world, state)[2].sum() == pytest.approx(2.0 * 0.05, rel=0.01)
    state.x[2] += 0.06
    assert np.abs(force(thread, world, state)).max() == 0
    charge = StaticCharge({"strength": 0.01}, {"x": -1.0, "y": 0.1, "core": 0.05})
    charge.begin(world)
    k, area = world.sheet.grid.at(4, 6), world.sheet.grid.area_m2
    away = state.x[:2, k] - [-1.0, 0.1]
    push = 0.01 * area[k] * away / (away @ away + 0.05**2)
    assert force(charge, world, flat(world))[:, k] == pytest.approx([*push, 0.0], rel=1e-9)
    jet = FanJet(
        {"speed": 2.0},
        {"x": 0.1, "y": 0.1, "z": 0.5, "dx": 0.0, "dy": 0.0, "dz": -1.0, "width": 0.05, "rate_1": 1.0, "rate_2": 2.5},
    )
    jet.begin(world)
    state = flat(world)
    assert np.abs(force(jet, world, state)).max() == 0
    state.time_s, state.v[2] = 1.2, -0.5  # the sheet gives way to it
    blown = 2.0 * (1 + 0.35 * np.sin(2.4 * np.pi) + 0.25 * np.sin(6.0 * np.pi + 1)) - 0.5
    share = np.exp(-np.sum((state.x[:2, k] - 0.1) ** 2) / 0.05**2)
    assert 0.05 < share < 0.9
    pressed = 0.5 * 1.2 * 1.2 * area[k] * share * blown**2
    assert force(jet, world, state)[:, k] == pytest.approx([0.0, 0.0, -pressed], rel=1e-9)
    wet = Drying({"mass": 0.01, "time": 1.0}, {"centre_u": 0.1, "centre_v": 0.1, "radius": 0.05})
    wet.begin(world)
    state.time_s = 1.5
    assert force(wet, world, state)[2].sum() == pytest.approx(-0.01 * 9.81 * np.exp(-1), rel=1e-6)
    shaking = GripperVibration({"amplitude": 0.002, "rate": 10.0}, {"x": 0.0, "y": 1.0, "z": 0.0})
    times = np.arange(0, 2, 1e-3)
    told = Poses(np.zeros((len(times), 1, 3)), np.broadcast_to(np.eye(3), (len(times), 1, 3, 3)))
    moved = shaking.poses(times, told).position_m[:, 0]
    assert np.abs(moved[times < 0.55]).max() == 0
    assert np.abs(moved[:, 1]).max() == pytest.approx(0.002, rel=0.01)
