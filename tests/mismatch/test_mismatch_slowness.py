"""How much a mesh still gets wrong, by how its refinements fall off."""

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.compare import MESH_SHARE, SLOWEST, observe, slowness
from sim1.mismatch.engine import FOLLOW_HZ, Engine


@pytest.fixture(scope="module")
def bundle():
    return filmed(empty_bundle(motions=2, duration_s=1.0))


@pytest.mark.parametrize("ratio", [0.0, 0.25, 0.375, 0.5, 0.6])
def test_changes_that_fall_off_evenly_leave_the_sum_of_all_that_are_to_come(bundle, ratio):
    one = observe(bundle.recordings[0])
    last = np.full(bundle.recordings[0].markers_m.shape, 1e-3)
    expected = max(1.0, ratio * (1.0 + MESH_SHARE) / MESH_SHARE)
    assert slowness(one, last, ratio * last) == pytest.approx(expected)
    left = ratio / (1.0 - ratio) * 1e-3  # of a geometric series
    claimed = slowness(one, last, ratio * last) * MESH_SHARE * 1e-3
    if ratio <= 0.375:
        assert claimed >= left
    else:  # not to be trusted as a series any more: more than a change of the last size, less than the sum
        assert 0.5 * left < claimed <= left


def test_where_refining_changes_ever_more_the_error_is_taken_to_be_unknown_and_not_without_end(bundle):
    one = observe(bundle.recordings[0])
    last = np.full(bundle.recordings[0].markers_m.shape, 1e-3)
    assert slowness(one, last, 10.0 * last) == SLOWEST
    assert slowness(one, 0.0 * last, 1e-7 * last) == 1.0  # rounding is no change


def test_it_is_measured_once_where_models_are_compared_and_widens_what_the_mesh_gets_wrong(bundle):
    with Engine(bundle) as engine:
        world, names = plain_world(bundle), engine.names
        engine.follow_hz = 2.0 * FOLLOW_HZ
        engine.refine(world, names)
        assert [engine.stages[name].slow for name in names] == [None, None]
        engine.follow_hz = FOLLOW_HZ
        engine.refine(world, names)
        slow = {name: engine.stages[name].slow for name in names}
        assert all(1.0 <= value <= SLOWEST for value in slow.values())
        engine.stages[names[0]].slow = 1.0
        engine.refine(world, names[:1])
        narrow = engine.observed(names[0]).mesh_m
        engine.stages[names[0]].slow = 3.0
        engine.refine(world, names[:1])  # as it is known, it is not measured again
        assert engine.stages[names[0]].slow == 3.0
        wide = engine.observed(names[0]).mesh_m
        assert wide.max() / narrow.max() == pytest.approx(3.0, rel=0.05)
        assert (wide >= narrow).all()


def test_a_recording_that_a_finer_mesh_cannot_follow_is_trusted_least(bundle, monkeypatch):
    whole = Engine.attempted

    def attempted(self, tasks):
        if all(task.finer > self.finest for task in tasks):
            return [NotConverged("recording swing_0: no next state at 0.5 s") for _ in tasks]
        return whole(self, tasks)

    monkeypatch.setattr(Engine, "attempted", attempted)
    with Engine(bundle) as engine:
        engine.refine(plain_world(bundle), engine.names)
        assert {engine.stages[name].slow for name in engine.names} == {SLOWEST}
