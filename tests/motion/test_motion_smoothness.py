"""Figures of one way: how smooth it is, how it joins, and what is told of its shape."""

import numpy as np
import pytest
from made_up_paths import arched, reach, some_paths

from sim1.motion.likeness.features import FEATURES, Movement, canonical, features
from sim1.motion.likeness.joins import common_steps, inner_frames, join_ratios, steps_at
from sim1.motion.likeness.smoothness import (
    log_dimensionless_jerk,
    path_ratio,
    spectral_arc_length,
    speed,
    speed_peaks,
    turned_rad,
)
from sim1.motion.placement import planar
from sim1.motion.poses import ToolPath


def test_minimum_jerk_has_the_dimensionless_jerk_of_theory():
    # 720 L^2 / T^5 over (1.875 L / T)^2, times T^3
    assert log_dimensionless_jerk(reach(3001)) == pytest.approx(-np.log(720 / 1.875**2), abs=0.01)


@pytest.mark.parametrize("figure", [log_dimensionless_jerk, path_ratio, speed_peaks, turned_rad])
def test_smoothness_depends_neither_on_size_nor_on_place(figure):
    way = arched(np.random.default_rng(0)).position_m[:, 0]
    moved = 3 * way @ planar(np.zeros(2), 0.8, np.zeros(3))[:3, :3].T + [0.2, -0.1, 0.4]
    assert figure(moved) == pytest.approx(figure(way), rel=1e-9)


def test_spectral_arc_length_depends_neither_on_size_nor_on_duration():
    base = spectral_arc_length(speed(reach()))
    assert spectral_arc_length(7 * speed(reach())) == pytest.approx(base)
    assert spectral_arc_length(speed(reach(181))) == pytest.approx(base, abs=0.02)
    assert base == pytest.approx(-1.4, abs=0.1)  # a bell has one hump in its spectrum


def test_stopping_on_the_way_makes_a_movement_less_smooth_in_every_sense():
    twice = np.concatenate([reach(46, 0.15), reach(46, 0.15)[1:] + np.array([0.15, 0, 0])])
    assert speed_peaks(reach()) == 1
    assert speed_peaks(twice) == 2
    assert log_dimensionless_jerk(twice) < log_dimensionless_jerk(reach()) - 1
    assert spectral_arc_length(speed(twice)) < spectral_arc_length(speed(reach())) - 0.2


def test_a_half_circle_is_longer_than_its_chord_by_half_of_pi_and_turns_by_pi():
    angle = np.linspace(0, np.pi, 200)
    way = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    assert path_ratio(way) == pytest.approx(np.pi / 2, rel=1e-3)
    assert turned_rad(way) == pytest.approx(np.pi, rel=0.01)


def test_an_inserted_step_is_the_gap_of_its_join():
    at_rest = np.zeros((20, 2, 3))
    stepped = at_rest.copy()
    stepped[10:, 1, 2] = 0.004
    position, velocity, acceleration = steps_at(stepped, np.array([10]))[0]
    assert position == pytest.approx(0.004)
    assert velocity == pytest.approx(0.004 * 30)
    assert acceleration == pytest.approx(2 * 0.004 * 900)
    assert not steps_at(stepped, np.array([5, 14])).any()


def test_steps_of_velocity_and_acceleration_are_found_and_even_motion_has_neither():
    time = np.arange(30.0)
    kink = 0.01 * np.maximum(time - 15, 0)[:, None, None] * np.ones((1, 2, 3)) / np.sqrt(3)
    assert steps_at(kink, np.array([16]))[0, 1] == pytest.approx(0.01 * 30)
    even = 0.01 * time[:, None, None] * np.ones((1, 2, 3))
    assert np.abs(steps_at(even, inner_frames(30))[:, 1:]).max() < 1e-9


def test_a_path_joined_to_itself_is_no_more_abrupt_than_itself():
    paths = some_paths(4, 0).tools
    every = [inner_frames(len(path)).tolist() for path in paths]
    np.testing.assert_allclose(join_ratios(paths, every, common_steps(paths)), 1)


def test_features_say_nothing_of_the_place_on_the_table():
    path = arched(np.random.default_rng(3))
    elsewhere = path.moved(planar(np.array([0.1, -0.2]), 0.7, np.zeros(3)))
    here, there = (features(Movement(path=item, order=1, sources=frozenset())) for item in (path, elsewhere))
    assert len(here) == len(FEATURES)
    np.testing.assert_allclose(here, there, atol=1e-9)


def test_an_arm_that_rests_has_no_smoothness():
    path = arched(np.random.default_rng(3))
    position = path.position_m.copy()
    position[:, 1] = position[0, 1]
    movement = Movement(
        path=ToolPath(position_m=position, rotation=path.rotation, openness=path.openness), order=0, sources=frozenset()
    )
    values = dict(zip(FEATURES, features(movement), strict=True))
    assert movement.arms == [0]
    assert values["left.moves"] == 1
    assert not any(value for name, value in values.items() if name.startswith("right."))


def test_a_canonical_way_starts_at_the_origin_and_ends_ahead():
    way = canonical(reach() @ planar(np.zeros(2), 2.0, np.zeros(3))[:3, :3].T + [0.3, 0.2, 0.1])
    np.testing.assert_allclose(way[[0, -1]], [[0, 0, 0], [1, 0, 0]], atol=1e-12)
