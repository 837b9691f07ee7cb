"""How much a mesh still gets wrong, by how its refinements fall off."""

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.compare import MESH_SHARE, SLOWEST, not_imitated, slowness
from sim1.mismatch.engine import FOLLOW_HZ, Engine
from sim1.mismatch.search import baseline


@pytest.fixture(scope="module")
def bundle():
    return filmed(empty_bundle(motions=2, duration_s=1.0))


@pytest.mark.parametrize("ratio", [0.0, 0.25, 0.375, 0.5, 0.6])
def test_changes_that_fall_off_evenly_leave_the_sum_of_all_that_are_to_come(ratio):
    last = np.full(500, 1e-3)
    claimed = slowness(MESH_SHARE * last, ratio * last) * MESH_SHARE * 1e-3
    assert claimed == pytest.approx(1e-3 * max(MESH_SHARE, ratio * (1.0 + MESH_SHARE)))
    to_come = ratio / (1.0 - ratio) * 1e-3  # of a geometric series
    assert claimed >= to_come if ratio <= 0.375 else 0.5 * to_come < claimed <= to_come


def test_where_refining_changes_ever_more_the_error_is_taken_to_be_unknown_and_not_without_end():
    last = np.full(500, 1e-3)
    assert slowness(MESH_SHARE * last, 10.0 * last) == SLOWEST


def test_what_coefficients_can_follow_within_their_priors_is_no_error_of_the_mesh():
    stream = np.random.default_rng(0)
    lead = 1e-3 * stream.standard_normal((3, 2000))  # per prior standard deviation
    other = 1e-3 * stream.standard_normal(2000)
    followed = np.array([0.5, -1.0, 0.2]) @ lead
    np.testing.assert_allclose(not_imitated(followed, lead, 1e-4), 0.0, atol=1e-6)
    left = not_imitated(followed + other, lead, 1e-4)
    assert np.sqrt(np.mean((left - other) ** 2)) < 0.1e-3
    faint = 1e-8 * lead  # so little that it would take a hundred thousand deviations
    np.testing.assert_allclose(not_imitated(followed, faint, 1e-4), followed, rtol=1e-3, atol=1e-9)


def test_it_is_measured_once_where_models_are_compared_and_widens_what_the_mesh_gets_wrong(bundle):
    plain = baseline(bundle)
    z = np.zeros(plain.count)
    with Engine(bundle) as engine:
        names = engine.names
        engine.follow_hz = 2.0 * FOLLOW_HZ
        engine.refine(plain.world(z), names)
        engine.soften(plain, z, names)
        assert [engine.stages[name].slow for name in names] == [None, None]
        engine.follow_hz = FOLLOW_HZ
        engine.refine(plain.world(z), names)
        assert [engine.stages[name].slow for name in names] == [None, None]
        engine.soften(plain, z, names)
        assert all(1.0 <= engine.stages[name].slow <= SLOWEST for name in names)
        wide = {}
        for slow in (1.0, 3.0):  # as it is known, it is not measured again
            engine.stages[names[0]].slow = slow
            engine.refine(plain.world(z), names[:1])
            assert engine.stages[names[0]].slow == slow
            wide[slow] = engine.observed(names[0]).mesh_m
            engine.soften(plain, z, names[:1])
            once = engine.observed(names[0]).mesh_m
            engine.soften(plain, z, names[:1])  # twice is no more than once
            np.testing.assert_allclose(engine.observed(names[0]).mesh_m, once, rtol=1e-6)
        np.testing.assert_allclose(wide[3.0], 3.0 * wide[1.0], rtol=0.05)


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
