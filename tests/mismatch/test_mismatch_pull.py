"""Simulations that keep to a recording, and what motions foretell of each other."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world

from sim1.cloth.precise.motions import Motions
from sim1.cloth.precise.pull import GAP_S, Goals, Pull
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import simulate
from sim1.mismatch.workers import Task, Workers


@pytest.fixture(scope="module")
def bundle():
    return filmed(empty_bundle(duration_s=1.5, motions=2), noise_m=3e-4)


@pytest.fixture(scope="module")
def world(bundle):
    return plain_world(bundle)


def rms(values):
    return float(np.sqrt(np.nanmean(np.square(values))))


def swing(time_s, hz=2.0, size_m=0.1):
    return size_m * np.sin(2 * np.pi * hz * time_s)[:, None, None] * np.array([0.0, 1.0, 0.0])


def test_goals_do_not_cut_the_corners_of_a_fast_swing(world):
    time = np.arange(0, 2, 0.0125)
    inside = np.arange(0.2, 1.8, 0.01)
    places, speeds = Goals.of(time, swing(time)).at(inside, [world])
    assert rms(places[0] - swing(inside)) < 0.003 * rms(swing(inside))
    rate = np.gradient(swing(inside), inside, axis=0)
    assert rms((speeds[0] - rate)[2:-2]) < 0.01 * rms(rate)


def test_goals_take_most_of_the_noise_out(world):
    time = np.arange(0, 2, 0.0125)
    noise = 1e-3 * np.random.default_rng(0).standard_normal((len(time), 1, 3))
    places, _ = Goals.of(time, noise).at(time[10:-10], [world])
    assert rms(places) < 0.7e-3


def test_a_hidden_marker_pulls_nobody(world):
    time = np.arange(0, 2, 0.0125)
    markers = swing(time)
    hidden = (time > 0.8) & (time < 1.2)
    markers[hidden] = np.nan
    places, speeds = Goals.of(time, markers).at(time, [world])
    missing = np.isnan(places[0, :, 0, 0])
    assert missing[(time > 0.8 + GAP_S) & (time < 1.2 - GAP_S)].all()
    assert not missing[(time > 0.1) & (time < 0.75)].any()
    assert (np.isnan(speeds) == np.isnan(places)).all()


def test_goals_undo_clock_and_frame_as_the_world_has_them(world):
    time = np.arange(0, 2, 0.0125)
    late = replace(world, clock_offset_s=0.05, frame_shift_m=(0.0, 0.0, 0.2))
    reported = swing(time - 0.05) + np.array([0.0, 0.0, 0.2])
    places, _ = Goals.of(time, reported).at(np.arange(0.3, 1.7, 0.01), [late])
    assert rms(places[0] - swing(np.arange(0.3, 1.7, 0.01))) < 0.5e-3


def test_a_pulled_simulation_stays_near_what_was_seen_although_its_parameters_are_wrong(bundle, world):
    recording = bundle.recordings[0]
    scene = prepare(bundle, recording, 1 / 60, finer=1)
    wrong = replace(world, bending_n_m=4 * world.bending_n_m)
    goals = Goals.of(recording.time_s, recording.markers_m)
    free, pulled = (simulate(scene, [wrong], pull=pull).markers_m[0] for pull in (None, Pull(hz=2.0, goals=goals)))
    assert rms(pulled - recording.markers_m) < 0.7 * rms(free - recording.markers_m)


def test_what_is_pulled_does_not_depend_on_mass_when_all_ratios_to_it_stay(bundle, world):
    recording = bundle.recordings[0]
    scene = prepare(bundle, recording, 1 / 60)
    heavy = replace(
        world,
        area_density_kg_m2=2 * world.area_density_kg_m2,
        stretch_n_m=2 * world.stretch_n_m,
        bending_n_m=2 * world.bending_n_m,
    )
    pull = Pull(hz=2.0, goals=Goals.of(recording.time_s, recording.markers_m))
    one, two = (simulate(scene, [w], pull=pull).markers_m[0] for w in (world, heavy))
    assert rms(one - two) < 3e-5


def test_slopes_under_a_pull_are_those_of_differences(bundle, world):
    recording = bundle.recordings[1]
    scene = prepare(bundle, recording, 1 / 60)
    pull = Pull(hz=2.0, goals=Goals.of(recording.time_s, recording.markers_m))
    for change in ({"bending_n_m": 1.001}, {"stretch_n_m": 1.001}, {"damping_s": 1.001}):
        other = replace(world, **{name: factor * getattr(world, name) for name, factor in change.items()})
        run = simulate(scene, [world, other], pull=pull)
        difference = simulate(scene, [other, other], pull=pull, near=run.rest_m).markers_m[0] - run.markers_m[0]
        told = run.markers_m[1] - run.markers_m[0]
        assert rms(told - difference) < 0.05 * rms(difference) + 2e-8, change


def test_a_motion_and_its_twins_foretell_a_similar_one(bundle, world):
    scene = prepare(bundle, bundle.recordings[1], 1 / 60)
    twin = replace(world, bending_n_m=1.00001 * world.bending_n_m)
    run = simulate(scene, [world, twin], leads=True)
    motions = Motions()
    motions.keep([world, twin], run.shapes_m, run.leads_m)
    other = replace(world, bending_n_m=1.05 * world.bending_n_m)
    truth = simulate(scene, [other])
    guess = motions.guess(other)
    assert rms(guess - truth.shapes_m) < 0.2 * rms(run.shapes_m - truth.shapes_m)
    guided = simulate(scene, [other], near=guess[0], guess=guess)
    assert np.abs(guided.shapes_m - truth.shapes_m).max() < 5e-5


def test_a_motion_without_twins_foretells_by_those_of_the_one_that_foretold_it(bundle, world):
    scene = prepare(bundle, bundle.recordings[1], 1 / 60)
    stiffer = [replace(world, bending_n_m=factor * world.bending_n_m) for factor in (1.00001, 1.05, 1.1)]
    run = simulate(scene, [world, stiffer[0]], leads=True)
    motions = Motions()
    motions.keep([world, stiffer[0]], run.shapes_m, run.leads_m)
    motions.guess(stiffer[1])
    alone = simulate(scene, [stiffer[1]], leads=True)
    motions.keep([stiffer[1]], alone.shapes_m, alone.leads_m)
    truth = simulate(scene, [stiffer[2]]).shapes_m
    assert rms(motions.guess(stiffer[2]) - truth) < 0.2 * rms(alone.shapes_m - truth)


def test_a_recording_that_does_not_use_a_grip_answers_nothing_for_it(bundle, world):
    moved = replace(world, places=tuple((1e-3, *(0.0,) * 5) for _ in world.places))
    elsewhere = replace(world, places=(*world.places, (1.0,) * 6))
    workers = Workers(bundle, processes=1)
    try:
        (done,) = workers(
            [Task(recording="swing_0", worlds=(world, moved, elsewhere), finer=0, step_s=1 / 60, follow_hz=2.0)]
        )
    finally:
        workers.close()
    assert rms(done.markers_m[1] - done.markers_m[0]) > 0
    assert (done.markers_m[2] == done.markers_m[0]).all()
