"""Placebos of the diagnosis: fingerprints with their time, places or directions mixed up, screened beside the true ones."""

import json
import shutil

import numpy as np
import pytest

from benchmarks.diagnosis import asked as asked_about
from benchmarks.diagnosis import placebo as of
from benchmarks.diagnosis.asked import answers_of, bundle_of
from benchmarks.diagnosis.placebo import KINDS, mixed, placebos

MOVED_M = np.random.default_rng(1).normal(size=(2, 20, 5, 3))  # twins, blocks, markers, axes


@pytest.mark.parametrize("kind", KINDS)
def test_mixed_fingerprints_are_as_large_as_the_true_ones_and_not_the_same(kind):
    told = mixed(MOVED_M, kind, np.random.default_rng(3))
    assert np.isclose(np.square(told).sum(), np.square(MOVED_M).sum())
    assert np.abs(told - MOVED_M).max() > 0.1


def test_each_kind_keeps_what_it_does_not_mix():
    at_rest = np.broadcast_to(MOVED_M[:, :1], MOVED_M.shape)
    assert (mixed(at_rest, "time", np.random.default_rng(3)) == at_rest).all()
    everywhere = np.broadcast_to(MOVED_M[:, :, :1], MOVED_M.shape)
    assert (mixed(everywhere, "places", np.random.default_rng(3)) == everywhere).all()
    lengths = np.linalg.norm(mixed(MOVED_M, "directions", np.random.default_rng(3)), axis=-1)
    assert np.allclose(lengths, np.linalg.norm(MOVED_M, axis=-1))


def test_a_kind_that_is_not_known_is_refused():
    with pytest.raises(ValueError, match="'mass'"):
        mixed(MOVED_M, "mass", np.random.default_rng(3))


def folder(tmp_path, name, *effects):
    path = tmp_path / name
    path.mkdir()
    listed = [{"name": effect, "parameters": {}, "named_by_format": True} for effect in effects]
    case = {"effects": list(effects), "strength": "medium", "seed": 1}
    answers = {"case": case, "effects": listed, "baseline": {}, "places_given": True}
    (path / "answers.json").write_text(json.dumps(answers))
    return path


def test_what_was_concealed_is_set_against_the_best_placebo_of_each_kind_and_no_case_is_asked_twice(
    tmp_path, monkeypatch
):
    asked = []

    def gains(name, seed):
        asked.append((name, seed))
        true = {"air_drag": 90.0 if name == "drag" else 3.0, "wind": 40.0}
        return {"true": true, "time": {"wind": 20.0}, "places": {"wind": 95.0}, "directions": {"air_drag": 4.0}}

    monkeypatch.setattr(asked_about, "read_bundle", lambda path: path.name)
    monkeypatch.setattr(of, "gains", gains)
    folders = [folder(tmp_path, "drag", "air_drag"), folder(tmp_path, "nothing")]
    for _ in range(2):
        table = placebos(folders, tmp_path / "out", lambda line: None, seed=7).splitlines()
    assert asked == [("drag", 7), ("nothing", 7)]
    assert table[2] == "| air_drag | 90 | 40 | 20 | 95 | 4 |"
    assert table[3] == "| nothing | - | 40 | 20 | 95 | 4 |"
    assert table[-1].endswith("with time mixed in 1, with places mixed in 0, with directions mixed in 1.")
    assert "Of 1 cases" in table[-1]


def test_cases_are_those_of_the_laboratory_or_of_a_campaign(tmp_path):
    case = folder(tmp_path, "case", "wind")
    (case / "bundle").mkdir()
    assert bundle_of(case) == case / "bundle"
    of_campaign = tmp_path / "bundles" / "case_007"
    of_campaign.mkdir(parents=True)
    (tmp_path / "answers").mkdir()
    shutil.copy(case / "answers.json", tmp_path / "answers" / "case_007.json")
    assert bundle_of(of_campaign) == of_campaign
    assert answers_of(of_campaign) == answers_of(case)
