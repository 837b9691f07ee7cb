"""Each concealed effect does what its formula says."""

import numpy as np
import pytest
from concealed_world import flat, force, moving, rolled, world_of
from scipy.spatial.transform import Rotation
from test_concealed_physics import CLOTH, Bench

from benchmarks.concealed.effects.air import AddedMass, AirDrag, Wind
from benchmarks.concealed.effects.curl import BendingHysteresis, PlasticCrease, ViscoelasticCreep
from benchmarks.concealed.effects.measurement import GravityTilt
from benchmarks.concealed.effects.outside import Drying, FanJet, HiddenThread, Magnet, StaticCharge
from benchmarks.concealed.effects.patches import HeavyRegion, StiffRegion
from benchmarks.concealed.effects.robot import ActuatorLag, GripCompliance, GripperVibration, GripSlip
from benchmarks.concealed.effects.tabletop import Adhesion
from benchmarks.concealed.grips import Poses
from benchmarks.concealed.simulate import Gap
from benchmarks.concealed.table import Friction

AIR = {"c_normal": 1.0, "c_tangential": 0.1}
STEADY = {"gust": 0.0, "waves_1": 1.0, "waves_2": 4.0, "profile": 0.0}


def test_drag_is_quadratic_against_the_motion_and_wind_is_drag_of_a_resting_sheet():
    drag = AirDrag({"c_normal": 1.0, "c_tangential": 0.1})
    world = world_of(drag)
    drag.begin(world)
    area = world.sheet.grid.area_m2.sum()
    fast = force(drag, world, moving(world, (0, 0, 2.0))).sum(axis=1)
    assert fast == pytest.approx([0, 0, -0.5 * 1.2 * area * 4 * (1 + 0.3 / 65) / 1.15], rel=1e-9)
    middling = force(drag, world, moving(world, (0, 0, 0.25))).sum(axis=1)
    assert middling == pytest.approx([0, 0, -0.5 * 1.2 * area * 0.25**2], rel=1e-9), (
        "where the coefficient is its name's"
    )
    along = force(drag, world, moving(world, (1.0, 0, 0))).sum(axis=1)
    assert along == pytest.approx([-0.5 * 1.2 * area * 0.1, 0, 0], rel=1e-9)
    wind = Wind({"vx": 0.0, "vy": 0.0, "vz": 3.0}, AIR | STEADY)
    wind.begin(world)
    assert force(wind, world, flat(world))[2].sum() == pytest.approx(0.5 * 1.2 * area * 9, rel=1e-9)
    assert np.abs(force(wind, world, moving(world, (0, 0, 3.0)))).max() < 1e-12


def test_wind_blows_steadily_at_rest_then_in_gusts_with_its_mean_and_more_of_it_higher_up():
    wind = Wind(
        {"vx": 0.0, "vy": 0.0, "vz": 2.0}, AIR | {"gust": 0.1, "waves_1": 2.0, "waves_2": 5.0, "profile": 1 / 7}
    )
    world = world_of(wind)
    wind.begin(world)

    def speed(time_s, height_m):
        state = flat(world)
        state.time_s, state.x[2] = time_s, height_m
        return np.sqrt(force(wind, world, state)[2].sum() / (0.5 * 1.2 * world.sheet.grid.area_m2.sum()))

    course = np.array([speed(time, 0.65) for time in np.linspace(0.5, 4.0, 701)])
    assert course[:-1].mean() == pytest.approx(2.0, rel=1e-6)
    assert 0.05 < course[:-1].std() / 2.0 < 0.1
    assert np.abs(np.diff(course)).max() < 0.02, "no jump, where the gusts begin neither"
    assert [speed(time, 0.65) for time in (0.0, 0.3, 0.5)] == pytest.approx([2.0] * 3)
    assert speed(0.0, 0.8) / speed(0.0, 0.5) == pytest.approx(1.6 ** (1 / 7))
    assert 0 < speed(0.0, 0.0) < 1.2


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


def test_air_that_is_carried_takes_no_weight_off_a_sheet_that_slides():
    """It stops after the way of Coulomb, as without: the table bears the sheet's weight, and what is carried has none."""
    bench = Bench(CLOTH, 5, 5, friction=Friction(0.4, 0.4))
    bench.inner *= 0.2
    bench.v[0, bench.grid.inside] = 0.5
    start, mass = bench.x[0].copy(), np.where(bench.sheet.mass_kg > 0, bench.sheet.mass_kg, 1.0)
    carried = np.zeros((4, bench.grid.count))
    carried[2], carried[3] = 1.0, np.where(bench.sheet.mass_kg > 0, 1 / mass - 1 / (1.4 * mass), 0.0)
    number = max(1, int(1e-4 / bench.inner))
    weight = np.array([0.0, 0.0, -9.81])[:, None] * bench.sheet.mass_kg
    for _ in range(int(0.3 / (number * bench.inner))):
        bench.membrane.step(bench.x, bench.v, weight.copy(), bench.inner, number, bench.contact, 1.0, carried)
    way = (bench.x[0] - start)[bench.grid.inside]
    assert way == pytest.approx(0.5**2 / (2 * 0.4 * 9.81), rel=5e-3)


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


def test_lag_is_late_by_its_time_on_the_mean_and_starts_smoothly():
    """Of any command: the mean time of a pulse, and of first order what follows a jump would start with a kink."""
    times, time = np.arange(0, 3, 1e-3), 0.06
    turn = np.broadcast_to(np.eye(3), (len(times), 1, 3, 3))

    def followed(command):
        told = Poses(command[:, None, None] * np.ones(3), turn)
        return ActuatorLag({"time_constant": time}).poses(times, told).position_m[:, 0, 0]

    pulse = np.exp(-(((times - 1.0) / 0.1) ** 2)) * (1 + 0.5 * np.sin(20 * times))
    late = followed(pulse)
    assert late.sum() == pytest.approx(pulse.sum(), rel=1e-6)
    assert times @ late / late.sum() - times @ pulse / pulse.sum() == pytest.approx(time, rel=1e-3)
    jump = followed((times > 1.0).astype(float))
    since = times[1001:] - 1.0
    assert jump[1001:] == pytest.approx(1 - (1 + 2 * since / time) * np.exp(-2 * since / time), abs=0.02)
    assert jump.max() <= 1.0, "critically damped: it does not overshoot"


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
