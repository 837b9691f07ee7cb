import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sim1.motion.durations import DurationModel, fitted_durations
from sim1.motion.interpolant import interpolate, minimum_jerk, quintic_weights, slerp
from sim1.motion.likeness.joins import steps_at
from sim1.motion.placement import fitted_placement, planar, random_placement
from sim1.motion.poses import ToolPath, from_tokens, joined, rotation_from_6d, rotation_to_6d, to_tokens, turned_tokens
from sim1.motion.residual import assemble, residual_of
from sim1.motion.transitions import coming

PHASE = np.linspace(0, 1, 101)


@given(st.integers(0, 10_000))
def test_six_numbers_bring_every_rotation_back(seed):
    rotations = Rotation.random(5, rng=np.random.default_rng(seed)).as_matrix()
    np.testing.assert_allclose(rotation_from_6d(rotation_to_6d(rotations)), rotations, atol=1e-12)


def test_six_noisy_numbers_still_give_a_rotation():
    six = np.random.default_rng(1).normal(size=(50, 6))
    rotations = rotation_from_6d(six)
    np.testing.assert_allclose(
        rotations @ rotations.swapaxes(-1, -2), np.broadcast_to(np.eye(3), (50, 3, 3)), atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0)


def test_tokens_bring_a_path_back(pool):
    path = pool[0].path
    back = from_tokens(to_tokens(path))
    np.testing.assert_allclose(back.matrices(), path.matrices(), atol=1e-12)
    np.testing.assert_allclose(back.openness, path.openness)


def test_mirroring_twice_changes_nothing_and_keeps_rotations_proper(pool):
    path = pool[1].path
    mirrored = path.mirrored()
    np.testing.assert_allclose(np.linalg.det(mirrored.rotation), 1.0)
    np.testing.assert_allclose(mirrored.position_m[:, 0, 1], -path.position_m[:, 1, 1])
    np.testing.assert_allclose(mirrored.mirrored().matrices(), path.matrices(), atol=1e-12)


def test_minimum_jerk_at_rest_is_the_formula_of_flash_and_hogan():
    still = np.zeros(())
    values = minimum_jerk(np.array(2.0), np.array(5.0), PHASE, still, still)
    np.testing.assert_allclose(values, 2 + 3 * (10 * PHASE**3 - 15 * PHASE**4 + 6 * PHASE**5))


def test_minimum_jerk_keeps_given_rates_and_has_no_acceleration_at_its_ends():
    phase = np.linspace(0, 1, 100_001)
    values = minimum_jerk(np.array(0.0), np.array(1.0), phase, np.array(0.7), np.array(-0.4))
    step = phase[1]
    assert (values[1] - values[0]) / step == pytest.approx(0.7, abs=1e-3)
    assert (values[-1] - values[-2]) / step == pytest.approx(-0.4, abs=1e-3)
    assert np.diff(values, 2)[[0, -1]] / step**2 == pytest.approx([0, 0], abs=5e-3)


def test_slerp_turns_evenly():
    start = Rotation.from_euler("xyz", [0.3, -0.2, 0.5]).as_matrix()
    end = Rotation.from_euler("xyz", [-0.4, 0.8, 1.5]).as_matrix()
    path = slerp(start, end, np.linspace(0, 1, 9))
    turns = Rotation.from_matrix(path[:-1].swapaxes(-1, -2) @ path[1:]).magnitude()
    np.testing.assert_allclose(turns, turns[0])
    np.testing.assert_allclose(path[-1], end, atol=1e-12)


def neighbours(pool):
    """The frames before, of and after the demonstrated way back."""
    hold, back = pool[1].path, pool[2].path
    return hold[-3:], joined(hold[-1:], back), coming(back[-1:])


def test_boundary_poses_are_met_to_the_last_bit(pool):
    before, _, after = neighbours(pool)
    residual = np.random.default_rng(0).normal(0, 0.05, (10, 20))
    residual[[0, -1]] = 0
    made = assemble(before, after, residual, 37)
    for name in ("position_m", "rotation", "openness"):
        assert (getattr(made, name)[0] == getattr(before, name)[-1]).all()
        assert (getattr(made, name)[-1] == getattr(after, name)[0]).all()
    assert np.abs(made.position_m - interpolate(before, after, np.linspace(0, 1, 37), 36).position_m).max() > 0.01


def test_residual_and_interpolant_make_up_the_demonstration(pool):
    before, path, after = neighbours(pool)
    residual, _ = residual_of(before, path, after, 32)
    assert (residual[[0, -1]] == 0).all()
    made = assemble(before, after, residual, len(path))
    assert np.abs(made.position_m - path.position_m).max() < 2e-4


def test_a_path_goes_on_with_the_speed_acceleration_and_turning_of_its_neighbours():
    """A tool that swings and turns for ever is cut into three; the middle is made anew from three frames on either side."""
    time = np.arange(90) / 30
    swing = np.stack([0.2 * np.sin(1.5 * time), 0.1 * np.cos(2 * time), 0.1 * time], axis=-1)
    turn = Rotation.from_euler("z", (0.4 * np.sin(time))[:, None]).as_matrix()
    whole = ToolPath(
        position_m=np.repeat(swing[:, None], 2, axis=1),
        rotation=np.repeat(turn[:, None], 2, axis=1),
        openness=np.full((90, 2), 0.5),
    )
    made = interpolate(whole[27:30], whole[60:63], np.linspace(0, 1, 32), 31)
    path = joined(whole[:30], made[1:-1], whole[60:])
    turned = Rotation.from_matrix(path.rotation[:, 0]).as_rotvec()[:, None]
    joins = np.array([30, 60])
    assert steps_at(path.position_m, joins)[:, 1].max() < 0.03  # m/s, of speeds up to 0.4
    assert steps_at(path.position_m, joins)[:, 2].max() < 0.25  # m/s^2, of accelerations up to 0.6
    assert steps_at(turned, joins)[:, 1].max() < 0.05  # rad/s, of turning at 0.4


def test_from_rest_to_rest_the_tools_follow_flash_and_hogan(pool):
    start, end = pool[0].path[:1], pool[0].path[-1:]
    made = interpolate(joined(*[start] * 3), coming(end), PHASE, 100)
    share = 10 * PHASE**3 - 15 * PHASE**4 + 6 * PHASE**5
    wanted = start.position_m + share[:, None, None] * (end.position_m - start.position_m)
    np.testing.assert_allclose(made.position_m, wanted, atol=3e-4)  # rest lasts until the frame before


def test_a_quintic_goes_through_the_frames_that_it_is_given():
    weights = quintic_weights(np.array([-0.2, -0.1, 0, 1, 1.1, 1.2]), 10)
    np.testing.assert_allclose(weights, np.eye(6), atol=1e-12)
    quintic = np.polynomial.Polynomial([0.3, -1, 2, 0.5, -3, 1])
    given = quintic(np.array([-0.2, -0.1, 0, 1, 1.1, 1.2]))
    np.testing.assert_allclose(quintic_weights(PHASE, 10) @ given, quintic(PHASE), atol=1e-10)


def test_turned_tokens_are_those_of_a_turned_path(pool):
    path = pool[0].path
    turn = planar(np.zeros(2), 0.7, np.zeros(3))
    np.testing.assert_allclose(turned_tokens(to_tokens(path), turn[:3, :3]), to_tokens(path.moved(turn)), atol=1e-12)


def test_a_residual_changes_neither_pose_nor_speed_at_the_ends(pool):
    before, _, after = neighbours(pool)
    residual = 0.02 * np.sin(np.pi * np.linspace(0, 1, 32))[:, None] ** 2 * np.ones(20)
    made, plain = (assemble(before, after, part, 1001) for part in (residual, 0 * residual))
    added = made.position_m - plain.position_m
    assert np.abs(added).max() == pytest.approx(0.02, rel=0.01)
    assert np.abs(added[[1, -2]]).max() * 1000 < 0.001  # of slopes up to 0.06 in between


def test_a_garments_placement_is_recovered_from_its_vertices():
    rng = np.random.default_rng(4)
    before = np.concatenate([rng.uniform(-0.3, 0.3, (200, 2)), rng.uniform(0, 0.02, (200, 1))], axis=1)
    motion = random_placement(rng, 0.05, 0.26, before.mean(axis=0))
    now = before @ motion[:3, :3].T + motion[:3, 3]
    np.testing.assert_allclose(fitted_placement(before, now, rng.uniform(0.1, 1, 200)), motion, atol=1e-9)


def test_random_placements_stay_within_their_limits_and_turn_about_the_garment():
    rng = np.random.default_rng(4)
    centre = np.array([0.1, -0.05, 0.01])
    shifts = []
    for _ in range(300):
        motion = random_placement(rng, 0.05, 0.2, centre)
        shifts.append(np.linalg.norm(motion[:3, :3] @ centre + motion[:3, 3] - centre))
        assert abs(np.arctan2(motion[1, 0], motion[0, 0])) <= 0.2
    assert max(shifts) <= 0.05 + 1e-12
    assert max(shifts) > 0.04


def at_rest(pose):
    return joined(pose, pose, pose)


def test_durations_are_recovered_from_exact_ones(pool):
    home = pool[0].path[:1]
    ends = [home.moved(planar(np.array([distance, 0.0]), 0.0, np.zeros(3))) for distance in (0.1, 0.2, 0.3, 0.5, 0.8)]
    fitted = fitted_durations([(at_rest(home), at_rest(end)) for end in ends], [0.6, 0.8, 1.0, 1.4, 2.0])
    assert fitted.s_per_m == pytest.approx(2.0)
    assert fitted.rest_s == pytest.approx(0.4)
    assert fitted.log_std < 0.01
    between = home.moved(planar(np.array([0.4, 0.0]), 0.0, np.zeros(3)))
    assert fitted.mean_s(at_rest(home), at_rest(between)) == pytest.approx(1.2, rel=0.02)


def test_ways_out_and_back_keep_their_own_durations(pool):
    """Over the same distance, a way up takes three times as long as a way down: no line through both could say so."""
    high, low = pool[0].path[:1], pool[0].path[-1:]
    shown = [(at_rest(high), at_rest(low)), (at_rest(low), at_rest(high))] * 3
    fitted = fitted_durations(shown, [1.0, 3.0] * 3)
    assert fitted.mean_s(*shown[0]) == pytest.approx(1.0, rel=0.01)
    assert fitted.mean_s(*shown[1]) == pytest.approx(3.0, rel=0.01)


def test_a_duration_has_at_least_five_steps(pool):
    model = DurationModel(rest_s=0.01, s_per_m=0.0, s_per_rad=0.0, log_std=0.1)
    here = at_rest(pool[0].path[:1])
    assert model.sample_steps(here, here, np.random.default_rng(0)) == 5
