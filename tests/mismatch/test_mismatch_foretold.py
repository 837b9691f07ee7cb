"""Motion that no fit has seen is evidence like any other: counted in nats, and less where the simulator is no sure witness."""

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.mismatch.compare import observe
from sim1.mismatch.foretold import nats_against

NOISE_M = 3e-4
WIND = ("wind",)


class Foreteller:
    """Stands for an engine: what each model foretells is given, on the working mesh and on the other one."""

    other_mesh = 0

    def __init__(self, told, other):
        [self.recording, *_] = empty_bundle(motions=2).recordings
        noise = NOISE_M * np.random.default_rng(0).normal(size=self.recording.markers_m.shape)
        self.data = replace(
            observe(replace(self.recording, markers_m=self.recording.markers_m + noise)), noise_m=NOISE_M
        )
        self.told, self.other = told, other

    def foretell(self, world, names, finer=None):
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
    engine = Foreteller(told, other or told)
    null, model = (
        SimpleNamespace(terms=terms, fit=SimpleNamespace(unknowns=SimpleNamespace(world=lambda z, n=n: n), z=None))
        for n, terms in enumerate(((), WIND))
    )
    foretold = {terms: engine.foretell(n, ("only",)) for n, terms in enumerate(((), WIND))}
    return nats_against(engine, null, [model], foretold, ("only",))[WIND]


def test_what_foretells_worse_is_less_likely_and_the_other_way_round():
    assert against((0.0, 0.0)) == 0.0
    worse = against((0.0, 1e-3))
    assert worse > 100.0
    assert against((1e-3, 0.0)) == pytest.approx(-worse, rel=0.05)
    assert against((0.0, 3e-3)) > worse > against((0.0, 3e-4))


def test_where_another_mesh_says_another_thing_motion_is_less_of_a_witness():
    sure, unsure = against((0.0, 1e-3)), against((0.0, 1e-3), (0.0, -2e-3))
    assert 0.0 < unsure < 0.5 * sure
