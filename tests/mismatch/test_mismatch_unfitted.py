"""What a recording that no fit saw says of models: evidence like that of the fitted ones."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit, cost_of
from sim1.mismatch.models import Model
from sim1.mismatch.search import Term, baseline
from sim1.mismatch.unfitted import NOTHING, hear

DRAG, CURL = ("air_drag",), ("rest_curvature",)
HELD = ("swing_1",)


@pytest.fixture(scope="module")
def engine():
    bundle = filmed(empty_bundle(motions=2, duration_s=1.2), air_normal=3.0)
    with Engine(bundle) as engine:
        engine.refine(plain_world(bundle), engine.names)
        yield engine


def model(engine, terms=(), z=(0.5, -0.4, 0.6, -0.5), strengths=()):
    """A model at the concealed fabric, with effects of given strengths (z)."""
    plain = baseline(engine.bundle)
    unknowns = replace(plain, terms=tuple(Term.of(EFFECTS[name]) for name in terms))
    place = np.zeros(unknowns.count)
    place[:4] = z
    place[plain.count : plain.count + len(strengths)] = strengths
    return SimpleNamespace(terms=terms, fit=SimpleNamespace(unknowns=unknowns, z=place))


def test_what_was_concealed_makes_motion_that_no_fit_saw_likelier_and_what_was_not_does_not(engine):
    drag, curl = model(engine, DRAG, strengths=(2.0,)), model(engine, CURL, strengths=(1.0, 1.0))
    heard = hear(engine, model(engine), [drag, curl], HELD)
    assert heard.unasked == {}
    assert heard.against[DRAG] < -50.0
    assert heard.against[CURL] > -5.0


def test_what_was_heard_is_added_to_a_model_as_if_it_had_been_fitted_and_had_taught_nothing(engine):
    drag = model(engine, DRAG, strengths=(2.0,))
    heard = hear(engine, model(engine), [drag], HELD)
    own = {"swing_0": np.ones(6)}
    fit = Fit(
        unknowns=drag.fit.unknowns,
        z=drag.fit.z,
        names=("swing_0",),
        temper={"swing_0": 3.0},
        residuals=own,
        slopes={"swing_0": np.ones((6, len(drag.fit.z)))},
        mesh_off={"swing_0": np.zeros(6)},
        stretch={"swing_0": np.arange(6)},
        converged=True,
    )
    before = Model(terms=DRAG, fit=fit, variants=1)
    after = heard.added_to(before)
    assert after.fit.names == ("swing_0", *HELD)
    np.testing.assert_allclose(after.fit.covariance, fit.covariance)
    nats = cost_of(heard.residuals[DRAG], HELD, heard.temper)
    assert after.score - before.score == pytest.approx(nats)
    baseline_nats = cost_of(heard.residuals[()], HELD, heard.temper)
    assert heard.against[DRAG] == pytest.approx(nats - baseline_nats)
    for kept in (after.fit.residuals, after.fit.slopes, after.fit.mesh_off, after.fit.stretch):
        assert len(kept[HELD[0]]) == len(heard.residuals[DRAG][HELD[0]])


def test_what_is_known_of_errors_is_afterwards_what_it_was(engine):
    before = {name: engine.observed(name).mesh_m.copy() for name in engine.names}
    hear(engine, model(engine), [model(engine, DRAG, strengths=(2.0,))], HELD)
    for name, mesh_m in before.items():
        np.testing.assert_array_equal(engine.observed(name).mesh_m, mesh_m)


def test_nobody_is_asked_where_there_is_nothing_to_ask(engine):
    heard = hear(engine, model(engine), [], HELD)
    assert heard is NOTHING
    assert (heard.against, heard.unasked) == ({}, {})


def test_a_model_that_no_simulation_follows_says_nothing_and_the_others_are_asked(engine, monkeypatch):
    whole = Engine.residuals

    def residuals(self, unknowns, z, names):
        if unknowns.terms and unknowns.terms[0].effect.name == "rest_curvature":
            raise NotConverged("recording swing_1: no next state at 0.500 s")
        return whole(self, unknowns, z, names)

    monkeypatch.setattr(Engine, "residuals", residuals)
    drag, curl = model(engine, DRAG, strengths=(2.0,)), model(engine, CURL, strengths=(1.0, 1.0))
    heard = hear(engine, model(engine), [drag, curl], HELD)
    assert set(heard.against) == {DRAG}
    assert "no next state at 0.500 s" in heard.unasked[CURL]


def test_where_the_first_model_is_not_followed_nobody_is_asked(engine, monkeypatch):
    def refine(self, world, names):
        raise NotConverged("recording swing_1: no rest")

    monkeypatch.setattr(Engine, "refine", refine)
    heard = hear(engine, model(engine), [model(engine, DRAG, strengths=(2.0,))], HELD)
    assert heard.against == {}
    assert list(heard.unasked) == [DRAG]
