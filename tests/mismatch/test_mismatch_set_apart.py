"""What a name adds on motion held out is told beside the other name, not of both together."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle
from small_pool import pool_of

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.assimilate import Located
from sim1.mismatch.diagnose import _without_each
from sim1.mismatch.findings import verdict_of
from sim1.mismatch.foretold import Foretold
from sim1.mismatch.search import Term
from sim1.recording.document import Prior

PAIR, DRAG, CURL = ("air_drag", "rest_curvature"), ("air_drag",), ("rest_curvature",)


def off_by(bundle, error_m):
    """What a model foretells that is wrong by so much everywhere."""
    return Foretold(markers_m={r.name: r.markers_m + error_m for r in bundle.recordings}, lost={})


def test_each_name_is_measured_by_the_model_that_lacks_it_alone():
    bundle = empty_bundle(motions=2)
    told = {
        (): off_by(bundle, 8e-3),
        DRAG: off_by(bundle, 4e-3),
        CURL: off_by(bundle, 5e-3),
        PAIR: off_by(bundle, 1e-3),
    }
    names = (bundle.recordings[0].name,)
    assert _without_each(bundle, PAIR, told, names) == pytest.approx({"air_drag": 5e-3, "rest_curvature": 4e-3})
    assert _without_each(bundle, DRAG, told, names) == pytest.approx({"air_drag": 8e-3})
    del told[CURL]
    told[DRAG] = Foretold(markers_m={}, lost={names[0]: "no next state"})
    assert _without_each(bundle, PAIR, told, names) == {"air_drag": None, "rest_curvature": None}


def test_the_verdict_tells_what_each_of_two_names_adds(unknowns, monkeypatch):
    null, drag, pair = pool_of(unknowns, {DRAG: 300.0, PAIR: 500.0})
    terms = tuple(Term.of(EFFECTS[name]) for name in PAIR)
    pair = replace(pair, fit=replace(pair.fit, unknowns=unknowns.with_terms(*terms)))
    monkeypatch.setattr("sim1.mismatch.findings.effect_entry", lambda fit, term: {"name": PAIR[term], "parameters": {}})
    monkeypatch.setattr(
        "sim1.mismatch.findings.probabilities", lambda models, verdict, thresholds: dict.fromkeys(PAIR, 1.0)
    )
    found = SimpleNamespace(
        verdict="named",
        stopped=False,
        models=(pair, drag, null),
        heard=(),
        chosen=pair,
        baseline=null,
        rivals=(),
        lost=(),
        misfit={"baseline": 2.0, "chosen": 1.0},
        noise_m=3e-4,
        rmse_m={"baseline": {"fit": 8e-3, "heldout": 8e-3}, "augmented": {"fit": 1e-3, "heldout": 1e-3}},
        heldout_without_m={"air_drag": 5e-3, "rest_curvature": None},
        located=Located(forces=(), marker_power_n2=np.zeros(0), windows=(), signature="none", states=(), lost={}),
        remarks=("said",),
    )
    bundle = empty_bundle(motions=2)
    said = verdict_of(bundle, found)
    assert {one.name: one.heldout_rmse_reduction for one in said.missing_physics} == {
        "air_drag": pytest.approx(0.8),
        "rest_curvature": None,
    }
    assert said.remarks == ("said",)
    exact = bundle.prior.model_copy(update={"damping_s": Prior(value=2e-3)})
    again = verdict_of(replace(bundle, prior=exact), found)
    assert (
        again.remarks[1]
        == "bundle.yaml gives no spread to garment.prior.damping_s (0.002 s): taken as exact and not calibrated"
    )
