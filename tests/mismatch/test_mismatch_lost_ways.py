"""Where no simulation finds its way, what was known before stays."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch import contest
from sim1.mismatch.engine import FOLLOW_HZ, Engine
from sim1.mismatch.fit import fit
from sim1.mismatch.models import calibrate, judged
from sim1.mismatch.remarks import not_sharpened
from sim1.mismatch.search import baseline
from sim1.mismatch.thresholds import THRESHOLDS


def test_models_stay_as_they_were_where_no_mesh_says_what_is_wrong_at_the_best(bundle_engine, monkeypatch):
    """The coarser mesh finds no way with a crease in it: what is known of errors at the baseline is known still."""
    engine, found = bundle_engine
    before = engine.observed("swing_0")

    def lost(world, names):
        engine.stages["swing_0"].observed = replace(before, mesh_m=1.0 + before.mesh_m)
        raise NotConverged("recording swing_0: no next state at 0.900 s")

    monkeypatch.setattr(engine, "refine", lost)
    after = contest.sharpened(engine, found, ("swing_0", "swing_1"), THRESHOLDS)
    assert after == replace(found, unsharpened="recording swing_0: no next state at 0.900 s")
    assert "beside the baseline alone" in not_sharpened(after.unsharpened)
    assert engine.observed("swing_0") is before


def test_a_calibration_that_finds_no_way_leaves_the_engine_as_models_are_compared(bundle_engine, monkeypatch):
    engine, _ = bundle_engine
    plain = baseline(engine.bundle)

    def lost(world, names):
        raise NotConverged("recording swing_0: the sheet finds no rest at the start")

    monkeypatch.setattr(engine, "refine", lost)
    with pytest.raises(NotConverged):
        calibrate(engine, plain, np.zeros(plain.count), engine.names, lambda share: None)
    assert (engine.finer, engine.follow_hz) == (engine.finest, FOLLOW_HZ)


def test_of_no_simulations_there_are_no_answers(bundle_engine):
    assert bundle_engine[0].attempted([]) == []


@pytest.fixture(scope="module")
def bundle_engine():
    """An engine, and a contest of one model in which nothing is fitted."""
    bundle = empty_bundle(count=5, duration_s=1.0, motions=2)
    noisy = replace(bundle, noise_std_m=3e-4)
    plain, names = replace(baseline(noisy), nominal=()), ("swing_0", "swing_1")
    with Engine(noisy, processes=1) as engine:
        tempers = dict.fromkeys(names, 1.0)
        found = fit(engine, plain, np.zeros(0), names, temper=tempers, most=0)
        yield engine, contest.Contest(pool=[judged(found, tempers)], temper=tempers)
