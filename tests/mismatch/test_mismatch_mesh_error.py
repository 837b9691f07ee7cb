"""How much a mesh still gets wrong, by a coarser and by a finer one."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.compare import MESH_FLOOR_M, mesh_error, observe, off_by_coarser, off_by_finer
from sim1.mismatch.engine import FOLLOW_HZ, Engine


@pytest.fixture(scope="module")
def bundle():
    return filmed(empty_bundle(motions=2, duration_s=1.0))


@pytest.fixture
def engine(bundle):
    with Engine(bundle) as engine:
        yield engine


def test_meshes_whose_changes_fall_off_evenly_agree_on_what_is_to_come():
    """A geometric series: each change is 0.375 of the one before it."""
    ratio, last = 0.375, 1e-3
    here = np.zeros(5)
    coarser, finer, truth = here + last, here - ratio * last, here - last * ratio / (1 - ratio)
    assert off_by_coarser(here, coarser) == pytest.approx(here - truth)
    assert off_by_finer(here, finer) == pytest.approx(here - truth)


def test_where_changes_do_not_fall_off_the_finer_mesh_says_so():
    here, coarser, finer = np.zeros(5), np.full(5, 1e-3), np.full(5, -1e-3)
    assert (off_by_finer(here, finer) > 2.5 * off_by_coarser(here, coarser)).all()


def test_an_error_lasts_beyond_the_blocks_it_shows_in_and_never_vanishes(bundle):
    one = observe(bundle.recordings[0])
    assert mesh_error(one, 0.0 * one.measured_m) == pytest.approx(MESH_FLOOR_M)
    off = np.where(one.stretch == 0, 1e-3, 0.0)
    error = np.zeros(one.kept.shape)
    error[one.kept] = mesh_error(one, off)
    near = error[np.argmin(np.abs(one.block_s - 0.95))]  # the end of the stretch in which it is off
    assert (near > 5e-4).all()
    assert np.sqrt(np.mean(error[one.kept] ** 2)) == pytest.approx(np.sqrt(np.mean(off**2)), rel=0.1)


def test_what_is_not_seen_says_nothing_of_the_mesh(bundle):
    """A sheet that is off by a millimetre everywhere is so where it is seen, however seldom that is."""
    recording = bundle.recordings[0]
    hidden = recording.markers_m.copy()
    hidden[np.arange(len(hidden)) % 12 < 8] = np.nan
    hidden[:, :3] = np.nan
    one = observe(replace(recording, markers_m=hidden))
    assert 0.1 < one.kept.mean() < 0.4
    assert mesh_error(one, np.full(one.measured_m.shape, 1e-3)) == pytest.approx(np.hypot(1e-3, MESH_FLOOR_M))


def test_a_finer_mesh_is_asked_once_where_models_are_compared_and_takes_no_trust_back(bundle, engine):
    world, names = plain_world(bundle), engine.names
    engine.follow_hz = 2.0 * FOLLOW_HZ
    engine.refine(world, names)
    assert [engine.stages[name].finer_off_m for name in names] == [None, None]
    engine.follow_hz = FOLLOW_HZ
    engine.refine(world, names)
    first = engine.stages[names[0]]
    own = mesh_error(first.observed, first.finer_off_m)
    assert (first.observed.mesh_m >= own).all()
    first.finer_off_m = 10.0 * first.finer_off_m
    wide = first.finer_off_m
    engine.refine(world, names)
    assert first.finer_off_m is wide  # not asked again
    assert first.observed.mesh_m == pytest.approx(mesh_error(first.observed, wide))
    assert first.mesh_off_m is wide
    assert engine.mesh_off(names)[names[0]] == pytest.approx(first.observed.white(wide))


def test_a_recording_that_the_finer_mesh_cannot_follow_is_taken_to_change_as_much_again(bundle, engine, monkeypatch):
    world, names = plain_world(bundle), engine.names
    whole = Engine.attempted

    def attempted(self, tasks):
        if all(task.finer > self.finest for task in tasks):
            return [NotConverged("recording swing_0: no next state at 0.5 s") for _ in tasks]
        return whole(self, tasks)

    monkeypatch.setattr(Engine, "attempted", attempted)
    engine.refine(world, names)
    rough = engine.run([engine._task(names[0], (world,), 0, 1 / 60)])[0].markers_m[0]
    working = engine.run([engine.task(names[0], world)])[0].markers_m[0]
    stage = engine.stages[names[0]]
    expected = stage.observed.reduce(off_by_finer(rough, working))
    apart = np.linalg.norm(stage.finer_off_m - expected)  # both set out from other resting shapes
    assert apart < 0.03 * np.linalg.norm(expected)
