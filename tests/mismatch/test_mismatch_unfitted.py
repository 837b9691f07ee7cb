"""What a recording that no fit saw says of models: evidence like that of the fitted ones."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle, filmed, plain_world

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.search import Term, baseline
from sim1.mismatch.unfitted import nats_against

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
    against, unasked = nats_against(engine, model(engine), [drag, curl], HELD)
    assert unasked == {}
    assert against[DRAG] < -50.0
    assert against[CURL] > -5.0


def test_the_baseline_is_as_likely_as_itself(engine):
    against, _ = nats_against(engine, model(engine), [model(engine)], HELD)
    assert against == {(): 0.0}


def test_what_is_known_of_errors_is_afterwards_what_it_was(engine):
    before = {name: engine.observed(name).mesh_m.copy() for name in engine.names}
    nats_against(engine, model(engine), [model(engine, DRAG, strengths=(2.0,))], HELD)
    for name, mesh_m in before.items():
        np.testing.assert_array_equal(engine.observed(name).mesh_m, mesh_m)


def test_nobody_is_asked_where_there_is_nothing_to_ask(engine):
    assert nats_against(engine, model(engine), [], HELD) == ({}, {})


def test_a_model_that_no_simulation_follows_says_nothing_and_the_others_are_asked(engine, monkeypatch):
    whole = Engine.residuals

    def residuals(self, unknowns, z, names):
        if unknowns.terms and unknowns.terms[0].effect.name == "rest_curvature":
            raise NotConverged("recording swing_1: no next state at 0.500 s")
        return whole(self, unknowns, z, names)

    monkeypatch.setattr(Engine, "residuals", residuals)
    drag, curl = model(engine, DRAG, strengths=(2.0,)), model(engine, CURL, strengths=(1.0, 1.0))
    against, unasked = nats_against(engine, model(engine), [drag, curl], HELD)
    assert set(against) == {DRAG}
    assert "no next state at 0.500 s" in unasked[CURL]


def test_where_the_first_model_is_not_followed_nobody_is_asked(engine, monkeypatch):
    def refine(self, world, names):
        raise NotConverged("recording swing_1: no rest")

    monkeypatch.setattr(Engine, "refine", refine)
    against, unasked = nats_against(engine, model(engine), [model(engine, DRAG, strengths=(2.0,))], HELD)
    assert against == {}
    assert list(unasked) == [DRAG]
