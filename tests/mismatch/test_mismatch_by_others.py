"""A name that motion held out says too little of: what it gains most by is left out, and foretold by what the others teach."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world
from small_pool import pool_of

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.borne_out import borne_out, in_doubt
from sim1.mismatch.by_others import asked_of_others
from sim1.mismatch.decide import decide
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import fit, temper_of
from sim1.mismatch.models import judged
from sim1.mismatch.search import Term, baseline
from sim1.mismatch.thresholds import THRESHOLDS
from sim1.mismatch.unfitted import NOTHING, hear

DRAG = ("air_drag",)
FITTED, HELD = ("swing_0", "swing_1"), ("swing_2",)


def fitted_with(bundle):
    """An engine, and baseline and drag fitted to two recordings, the third heard."""
    engine = Engine(bundle)
    plain = baseline(bundle)
    model = replace(plain, terms=(Term.of(EFFECTS["air_drag"]),))
    z = np.zeros(plain.count)
    z[:4] = [0.5, -0.4, 0.6, -0.5]
    engine.refine(plain_world(bundle), FITTED)
    temper = temper_of(engine, engine.residuals(plain, z, FITTED), FITTED)
    start = np.insert(z, plain.count, np.full(model.count - plain.count, 0.5))
    null = judged(fit(engine, plain, z, FITTED, temper=temper, most=6), temper)
    drag = judged(fit(engine, model, start, FITTED, temper=temper, most=6), temper)
    return engine, null, drag, hear(engine, null, [drag], HELD)


@pytest.fixture(scope="module")
def everywhere():
    """Air in every recording."""
    engine, *rest = fitted_with(filmed(empty_bundle(duration_s=1.2), air_normal=3.0))
    with engine:
        yield engine, *rest


def test_recordings_with_the_same_air_in_them_foretell_each_other_by_it(everywhere):
    engine, null, drag, heard = everywhere
    said = asked_of_others(engine, null, drag, heard, HELD, THRESHOLDS)
    assert said.terms == DRAG
    assert said.recording in FITTED
    assert said.speaks
    assert said.against < -20.0


def test_what_is_wrong_in_one_recording_alone_the_others_do_not_foretell():
    """Air in the first swing only, as if something there were simulated wrongly."""
    airy, still = filmed(empty_bundle(duration_s=1.2), air_normal=3.0), filmed(empty_bundle(duration_s=1.2))
    bundle = replace(still, recordings=(airy.recordings[0], *still.recordings[1:]))
    engine, null, drag, heard = fitted_with(bundle)
    with engine:
        said = asked_of_others(engine, null, drag, heard, HELD, THRESHOLDS)
    assert said.recording == "swing_0"
    assert not said.speaks


def test_what_mesh_and_step_get_wrong_in_motion_held_out_is_known_while_it_teaches(everywhere, monkeypatch):
    engine, null, drag, heard = everywhere
    taught, before = {}, engine.observed(HELD[0]).mesh_m.copy()

    def fitted(engine, unknowns, z, names, **settings):
        taught.update({name: engine.observed(name).mesh_m.min() for name in names})
        return fit(engine, unknowns, z, names, **(settings | {"most": 0}))

    monkeypatch.setattr("sim1.mismatch.by_others.fit", fitted)
    asked_of_others(engine, null, drag, heard, HELD, THRESHOLDS)
    assert HELD[0] in taught
    assert min(taught.values()) > 0.0
    np.testing.assert_array_equal(engine.observed(HELD[0]).mesh_m, before)  # what was known of it is as it was


def test_where_no_simulation_follows_it_is_told_why_and_nothing_speaks(everywhere, monkeypatch):
    engine, null, drag, heard = everywhere

    def lost(*_, **__):
        raise NotConverged("recording swing_1: no next state at 0.5 s")

    monkeypatch.setattr("sim1.mismatch.by_others.fit", lost)
    said = asked_of_others(engine, null, drag, heard, HELD, THRESHOLDS)
    assert (said.against, said.speaks) == (None, False)
    assert "no next state at 0.5 s" in said.unasked
    silent = asked_of_others(engine, null, drag, NOTHING, HELD, THRESHOLDS)
    assert (silent.against, silent.speaks) == (None, False)
    assert "swing_2" in silent.unasked


@pytest.mark.usefixtures("counted_once")
def test_only_a_name_is_in_doubt_that_is_worth_enough_if_something_speaks_for_it(unknowns):
    little, doubtful, much = (pool_of(unknowns, {DRAG: share * THRESHOLDS.named}) for share in (0.9, 1.5, 2.2))

    def doubted(pool, nats, measured=frozenset()):
        found = in_doubt(decide(pool, THRESHOLDS, measured), pool, {DRAG: -nats}, THRESHOLDS, measured)
        return found and found.terms

    assert [doubted(pool, 0.0) for pool in (little, doubtful, much)] == [None, DRAG, None]
    assert doubted(doubtful, THRESHOLDS.spoken) is None  # no doubt is left
    assert doubted(doubtful, -0.6 * THRESHOLDS.named) is None  # motion held out speaks against it
    late = pool_of(unknowns, {("clock_offset",): 1.5 * THRESHOLDS.named})
    assert in_doubt(decide(late, THRESHOLDS), late, {}, THRESHOLDS, frozenset(["clock_offset"])) is None


@pytest.mark.usefixtures("counted_once")
def test_a_name_in_doubt_stands_if_a_recording_that_was_left_out_speaks_for_it(unknowns):
    pool = pool_of(unknowns, {DRAG: 1.5 * THRESHOLDS.named})
    found = decide(pool, THRESHOLDS)
    assert borne_out(found, pool, {DRAG: 0.0}, THRESHOLDS).verdict == "none"
    assert borne_out(found, pool, {DRAG: 0.0}, THRESHOLDS, others=frozenset([DRAG])).verdict == "named"
