"""Forces of the identification simulator and of what its baseline lacks, against formulas worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import SIDE_M, empty_bundle

from sim1.cloth.effects.anisotropic_friction import AnisotropicFriction
from sim1.cloth.precise.drives import late
from sim1.cloth.precise.forces import CONTACT_N_M3, residual
from sim1.cloth.precise.lacking import lacking_force
from sim1.cloth.precise.memory import remember, settle
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import simulate
from sim1.cloth.precise.world import gravity, pack

STEP_S, AREA_M2 = 1 / 60, SIDE_M**2


@pytest.fixture(scope="module")
def bundle():
    return empty_bundle(count=9)


@pytest.fixture(scope="module")
def flat(scene):
    """The sheet (V, 3) in the plane z = 0, its normal u x v upwards."""
    return np.column_stack([scene.sheet.material_m, np.zeros(len(scene.sheet.material_m))])


def forces(scene, world, x, velocity=None):
    """Forces (V, 3) [N] on a sheet without acceleration and weight, grips let go, bent to `x` from flat once."""
    net, cloth = scene.net, pack(scene.sheet, [replace(world, gravity_m_s2=(0.0, 0.0, 0.0))])
    curvature, moment, crease = (np.zeros((1, len(net.first) - 1, size)) for size in (3, 3, 6))
    settle(x[None], net, cloth, curvature, moment, crease)
    velocity = np.zeros_like(x) if velocity is None else velocity
    out, free = np.empty_like(x), np.zeros(len(net.held), bool)
    target = np.zeros((len(net.held), 3))
    residual(x, velocity, 0.0 * x, 1e-4, net, cloth, 0, curvature[0], moment[0], crease[0], target, free, out)
    return -out


def along(flat, velocity, count=9):
    """A motion (T, V, 3) of the flat sheet at a steady velocity."""
    return flat + np.arange(count)[:, None, None] * STEP_S * np.array(velocity)


def bowed(flat, kappa_u=0.0, kappa_v=0.0):
    """The sheet bent slightly: z = (kappa_u u^2 + kappa_v v^2) / 2."""
    u, v = flat[:, 0], flat[:, 1]
    return np.column_stack([u, v, 0.5 * (kappa_u * u**2 + kappa_v * v**2)])


# ---------------------------------------------------------------------- air


def test_wind_pushes_a_sheet_at_rest_by_the_square_of_its_speed(scene, world, flat):
    blown = replace(world, air_normal=1.3, wind_m_s=(0.0, 0.0, 1.5))
    force = lacking_force(scene, blown, world, along(flat, (0.0, 0.0, 0.0)))
    expected = 0.5 * world.air_density_kg_m3 * 1.3 * 1.5**2 * AREA_M2 / force.shape[1]
    np.testing.assert_allclose(force, np.broadcast_to([0.0, 0.0, expected], force.shape), atol=1e-6 * expected)


def test_a_sheet_that_goes_with_the_wind_feels_none(scene, world, flat):
    blown = replace(world, air_normal=1.3, air_skin=0.1, wind_m_s=(0.3, -0.2, 1.5))
    force = lacking_force(scene, blown, world, along(flat, (0.3, -0.2, 1.5)))
    assert np.abs(force).max() < 1e-12


def test_air_rubs_along_a_sheet_by_the_square_of_its_speed(scene, world, flat):
    force = lacking_force(scene, replace(world, air_skin=0.05), world, along(flat, (0.9, 1.2, 0.0)))
    size = 0.5 * world.air_density_kg_m3 * 0.05 * 1.5**2 * AREA_M2 / force.shape[1]
    expected = np.broadcast_to([-0.6 * size, -0.8 * size, 0.0], force.shape)
    np.testing.assert_allclose(force, expected, atol=1e-6 * size)


@pytest.mark.parametrize(
    ("direction", "share"), [((0.0, 0.0, 1.0), 1.0), ((1.0, 0.0, 0.0), 0.0), ((0.6, 0.0, 0.8), 0.8)]
)
def test_carried_air_resists_acceleration_across_the_sheet_alone(scene, world, flat, direction, share):
    time = STEP_S * np.arange(12)
    faster = flat + 0.5 * 4.0 * time[:, None, None] ** 2 * np.array(direction)
    force = lacking_force(scene, replace(world, added_mass_kg_m2=0.1), world, faster)[3:-3]  # ends are one-sided
    expected = -0.1 * 4.0 * share * AREA_M2 / force.shape[1]
    np.testing.assert_allclose(force[..., 2], expected, atol=1e-6)
    assert np.abs(force[..., :2]).max() < 1e-6


# ---------------------------------------------------------------------- weight


def test_a_tilted_rig_turns_gravity_about_x_first_and_then_about_y(world):
    a, b, g = 0.1, 0.2, 9.81
    about_x = [0.0, g * np.sin(a), -g * np.cos(a)]
    both = [-g * np.cos(a) * np.sin(b), g * np.sin(a), -g * np.cos(a) * np.cos(b)]
    np.testing.assert_allclose(gravity(replace(world, tilt_rad=(a, 0.0))), about_x)
    np.testing.assert_allclose(gravity(replace(world, tilt_rad=(a, b))), both)


def test_a_heavy_place_has_the_mass_that_is_said_where_it_is_said(scene, world):
    place = scene.sheet.material_m.mean(0) + np.array([0.01, -0.01])
    more = pack(scene.sheet, [replace(world, heavy_patch=(*place, 2e-3))]).mass[0] - pack(scene.sheet, [world]).mass[0]
    assert more.sum() == pytest.approx(2e-3)
    np.testing.assert_allclose(more @ scene.sheet.material_m / more.sum(), place, atol=2e-3)


def test_a_shrunk_sheet_weighs_what_it_did(scene, world):
    small = pack(scene.sheet, [replace(world, scale=(0.95, 0.97))]).mass[0]
    assert small.sum() == pytest.approx(world.area_density_kg_m2 * AREA_M2)


# ---------------------------------------------------------------------- stretch


def pull(scene, world, flat, stretch, axis):
    """Force [N] that holds a sheet together which is stretched evenly along an axis, cut across the middle."""
    x = flat.copy()
    x[:, axis] *= stretch
    beyond = flat[:, axis] > SIDE_M / 2 + 1e-6
    return -forces(scene, world, x)[beyond, axis].sum()


@pytest.mark.parametrize("axis", [0, 1])
def test_an_even_stretch_takes_the_stress_of_its_strain_along_the_threads(scene, world, flat, axis):
    """St. Venant-Kirchhoff: width x stretch x modulus x Green's strain; anisotropy keeps the moduli's geometric mean."""
    plain = replace(world, poisson=0.0, stretch_n_m=100.0)
    strain = 0.5 * (1.02**2 - 1.0)
    expected = SIDE_M * 1.02 * 100.0 * strain
    assert pull(scene, plain, flat, 1.02, axis) == pytest.approx(expected, rel=1e-6)
    ratio = 4.0 ** (0.5 if axis == 0 else -0.5)
    assert pull(scene, replace(plain, stretch_ratio=4.0), flat, 1.02, axis) == pytest.approx(ratio * expected, rel=1e-6)
    grown = 1.0 + 60.0 * strain
    assert pull(scene, replace(plain, stiffening=60.0), flat, 1.02, axis) == pytest.approx(grown * expected, rel=1e-6)


def test_yarns_that_are_pushed_together_do_not_stiffen(scene, world, flat):
    plain = replace(world, poisson=0.0)
    pushed = [pull(scene, one, flat, 0.98, 0) for one in (plain, replace(plain, stiffening=60.0))]
    assert pushed[0] == pytest.approx(pushed[1])
    assert pushed[0] < 0.0


def test_a_shrunk_sheet_is_without_stress_at_its_own_size(scene, world, flat):
    small = replace(world, scale=(0.95, 1.0))
    assert pull(scene, small, flat, 0.95, 0) == pytest.approx(0.0, abs=1e-9)
    strain = 0.5 * (1.0 / 0.95**2 - 1.0)
    expected = SIDE_M / 0.95 * small.stretch_n_m * strain  # at the scanned size, held by its width
    assert pull(scene, replace(small, poisson=0.0), flat, 1.0, 0) == pytest.approx(expected, rel=1e-6)


# ---------------------------------------------------------------------- bending


def moment(scene, world, flat, kappa, axis=0):
    """Moment per width [N] at a slight even curvature along an axis: the work of the forces per area and curvature."""
    way = bowed(flat, *(1.0 if k == axis else 0.0 for k in range(2)))[:, 2]
    x = bowed(flat, *(kappa if k == axis else 0.0 for k in range(2)))
    return -(forces(scene, replace(world, stretch_n_m=1e-9), x)[:, 2] * way).sum() / AREA_M2


@pytest.mark.parametrize("axis", [0, 1])
def test_bending_takes_a_moment_of_rigidity_times_what_is_beyond_the_curvature_at_rest(scene, world, flat, axis):
    stiff, tiny = world.bending_n_m, 1e-2
    assert moment(scene, world, flat, tiny, axis) == pytest.approx(stiff * tiny, rel=1e-3)
    curl = [0.0, 0.0]
    curl[axis] = 2.0
    curled = replace(world, curl_1_m=tuple(curl))
    assert moment(scene, curled, flat, 0.0, axis) == pytest.approx(-stiff * 2.0, rel=1e-3)
    assert moment(scene, curled, flat, 0.0, 1 - axis) == pytest.approx(0.0, abs=1e-9)
    ratio = 4.0 ** (0.5 if axis == 0 else -0.5)
    turned = replace(world, bending_ratio=4.0)
    assert moment(scene, turned, flat, tiny, axis) == pytest.approx(ratio * stiff * tiny, rel=1e-3)


def test_a_patch_is_stiffer_by_its_factor_inside_and_not_outside(scene, world):
    centre = scene.sheet.material_m.mean(0)
    away = np.linalg.norm(scene.sheet.material_m[scene.sheet.stencils.centre] - centre, axis=1)
    plain, patched = (pack(scene.sheet, [w]).bend[0] for w in (world, replace(world, stiff_patch=(*centre, 0.05, 7.0))))
    np.testing.assert_allclose(patched[away < 0.02] / plain[away < 0.02], 7.0, rtol=0.03)
    np.testing.assert_allclose(patched[away > 0.08] / plain[away > 0.08], 1.0, rtol=0.03)
    assert (away < 0.02).any()
    assert (away > 0.08).any()


def test_friction_of_bending_ends_at_its_moment_whichever_way_it_is_bent(scene, world, flat):
    """Dahl's model: after a change of curvature of many times the one at which it turns, all of the moment is there."""
    rubs = replace(world, hysteresis_n=1e-5, turn_1_m=1e-3)
    net, cloth = scene.net, pack(scene.sheet, [rubs])
    way, target, free = bowed(flat, 1.0)[:, 2], np.zeros((len(net.held), 3)), np.zeros(len(net.held), bool)
    curvature, felt, crease = (np.zeros((1, len(net.first) - 1, size)) for size in (3, 3, 6))
    settle(flat[None], net, cloth, curvature, felt, crease)
    found = []
    for kappa in [*np.linspace(0.0, 0.1, 101), *np.linspace(0.1, 0.05, 51)]:
        x, power = bowed(flat, kappa), []
        for one in (rubs, replace(rubs, hysteresis_n=0.0)):
            out = np.empty_like(x)
            arrays = pack(scene.sheet, [replace(one, gravity_m_s2=(0.0, 0.0, 0.0))])
            residual(x, 0.0 * x, 0.0 * x, 1e-4, net, arrays, 0, curvature[0], felt[0], crease[0], target, free, out)
            power.append((out[:, 2] * way).sum() / AREA_M2)
        found.append(power[0] - power[1])
        remember(x, net, cloth.scalar[0], curvature[0], felt[0], crease[0], np.zeros_like(curvature[0]))
    assert found[0] == pytest.approx(0.0, abs=1e-12)
    assert found[100] == pytest.approx(1e-5, rel=0.02)
    assert found[-1] == pytest.approx(-1e-5, rel=0.02)


# ---------------------------------------------------------------------- table


DEPTH_M = 5e-5


def braked(scene, world, flat, velocity):
    """Force (3,) [N] of a table on a sheet that is pressed into it evenly and slides."""
    sunk = flat - np.array([0.0, 0.0, DEPTH_M])
    rough = replace(world, table_z_m=0.0, air_normal=0.0)
    return forces(scene, rough, sunk, np.broadcast_to(np.array(velocity), flat.shape).copy()).sum(0)


def test_a_sliding_sheet_is_braked_by_friction_times_load_along_each_axis(scene, world, flat):
    load = DEPTH_M * CONTACT_N_M3 * AREA_M2
    rough = AnisotropicFriction(mu_x=0.6, mu_y=0.2).act(world)
    along_x, along_y = (braked(scene, rough, flat, v) for v in ((0.3, 0.0, 0.0), (0.0, 0.3, 0.0)))
    np.testing.assert_allclose(along_x, [-0.6 * load, 0.0, load], atol=1e-5 * load)
    np.testing.assert_allclose(along_y, [0.0, -0.2 * load, load], atol=1e-5 * load)


def test_a_sheet_that_hardly_slides_is_braked_more_by_its_static_friction(scene, world, flat):
    load = DEPTH_M * CONTACT_N_M3 * AREA_M2
    sticky = replace(world, friction=0.4, stiction=1.8, stribeck_m_s=0.02)
    slow, middling, fast = (-braked(scene, sticky, flat, (v, 0.0, 0.0))[0] / load for v in (0.002, 0.02, 0.2))
    assert slow == pytest.approx(0.4 * (1.0 + 0.8 * np.exp(-0.01)), rel=2e-3)
    assert middling == pytest.approx(0.4 * (1.0 + 0.8 / np.e), rel=1e-3)
    assert fast == pytest.approx(0.4, rel=1e-3)


@pytest.mark.parametrize(("gap_m", "share"), [(0.0, 1.0), (2.5e-4, 0.5), (6e-4, 0.0)])
def test_a_table_clings_by_its_pressure_and_lets_go_over_its_reach(scene, world, flat, gap_m, share):
    clings = replace(world, table_z_m=0.0, friction=0.4, adhesion_pa=2.0, cling_m=5e-4)
    pulled = forces(scene, clings, flat + np.array([0.0, 0.0, gap_m])).sum(0)
    np.testing.assert_allclose(pulled, [0.0, 0.0, -2.0 * share * AREA_M2], atol=1e-9)


# ---------------------------------------------------------------------- rig


def test_a_lag_follows_a_steady_drive_by_its_own_time_behind():
    time = STEP_S * np.arange(121)
    behind = late(0.3 * time[:, None], 0.05, STEP_S)[:, 0]
    np.testing.assert_allclose(behind, 0.3 * (time - 0.05 * (1.0 - np.exp(-time / 0.05))), atol=1e-12)


def test_cloth_creeps_in_its_grip_by_what_its_weight_is_beyond_the_threshold(bundle, world):
    recording = bundle.recordings[0]
    track = recording.drives["bar"]
    still = replace(track, position_m=np.repeat(track.position_m[:1], len(track.time_s), axis=0))
    scene = prepare(bundle, replace(recording, drives={"bar": still}), STEP_S)
    weight = 9.81 * world.area_density_kg_m2 * AREA_M2
    slips = replace(world, slip_threshold_n=0.4 * weight, slip_rate_m_n_s=0.05)
    moved = simulate(scene, [slips]).shapes_m
    sunk = moved[0, :, 2].mean() - moved[:, :, 2].mean(1)
    time = scene.time_s - scene.time_s[0]
    np.testing.assert_allclose(sunk, 0.05 * 0.6 * weight * time, rtol=0.02, atol=2e-4)
