"""Motion that no fit has seen is evidence like any other: counted in nats, and less where the simulator is no sure witness."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.compare import observe
from sim1.mismatch.foretold import foretold_by, nats_against

NOISE_M = 3e-4
WIND = ("wind",)


class Foreteller:
    """Stands for an engine: what each model foretells is given, on the working mesh and on the other one."""

    other_mesh = 0

    def __init__(self, told, other, lost_on_the_other_mesh=None):
        self.lost = lost_on_the_other_mesh
        [self.recording, *_] = empty_bundle(motions=2).recordings
        noise = NOISE_M * np.random.default_rng(0).normal(size=self.recording.markers_m.shape)
        self.data = replace(
            observe(replace(self.recording, markers_m=self.recording.markers_m + noise)), noise_m=NOISE_M
        )
        self.told, self.other = told, other

    def foretold(self, world, names, finer=None):
        if finer is not None and world == self.lost:
            return dict.fromkeys(names, NotConverged("recording only: no next state at 0.500 s"))
        off_m = (self.told if finer is None else self.other)[world]
        wave = np.sin(np.linspace(0.0, 40.0, len(self.recording.time_s)))[:, None, None]
        return dict.fromkeys(names, self.recording.markers_m + off_m * wave)

    def observed(self, name):
        return self.data

    def carry(self, name, mesh_m):
        return replace(self.data, mesh_m=mesh_m)

    def aside(self):
        return nullcontext()


def against(told, other=None) -> float:
    """Nats against the second of two models, by how far each foretells markers off [m]."""
    nats, unasked = asked(Foreteller(told, other or told))
    assert unasked == {}
    return nats[WIND]


def asked(engine):
    """What motion held out says of a baseline and a model, and what it cannot say."""
    null, model = (
        SimpleNamespace(terms=terms, fit=SimpleNamespace(unknowns=SimpleNamespace(world=lambda z, n=n: n), z=None))
        for n, terms in enumerate(((), WIND))
    )
    foretold = {terms: foretold_by(engine, one, ("only",)) for terms, one in (((), null), (WIND, model))}
    return nats_against(engine, null, [model], foretold, ("only",))


def test_what_foretells_worse_is_less_likely_and_the_other_way_round():
    assert against((0.0, 0.0)) == 0.0
    worse = against((0.0, 1e-3))
    assert worse > 100.0
    assert against((1e-3, 0.0)) == pytest.approx(-worse, rel=0.05)
    assert against((0.0, 3e-3)) > worse > against((0.0, 3e-4))


def test_where_another_mesh_says_another_thing_motion_is_less_of_a_witness():
    sure, unsure = against((0.0, 1e-3)), against((0.0, 1e-3), (0.0, -2e-3))
    assert 0.0 < unsure < 0.5 * sure


def test_a_model_that_no_simulation_follows_is_told_apart_and_the_others_are_asked():
    """Wind leads the sheet where no next state is found; the other models and recordings are none the worse."""
    told = {
        ("swing_0", 0.0): np.ones((4, 2, 3)),
        ("swing_1", 0.0): NotConverged("recording swing_1: no next state at 0.700 s"),
    }
    engine = SimpleNamespace(foretold=lambda world, names, finer: {name: told[name, world] for name in names})
    model = SimpleNamespace(fit=SimpleNamespace(unknowns=SimpleNamespace(world=lambda z: 0.0), z=None))
    found = foretold_by(engine, model, ("swing_0", "swing_1"))
    assert list(found.markers_m) == ["swing_0"]
    assert found.lost == {"swing_1": "recording swing_1: no next state at 0.700 s"}


def test_what_cannot_be_simulated_is_no_witness_for_or_against():
    engine = Foreteller((0.0, 1e-3), (0.0, 1e-3), lost_on_the_other_mesh=1)
    nats, unasked = asked(engine)
    assert nats == {}
    assert "no next state" in unasked[WIND]
