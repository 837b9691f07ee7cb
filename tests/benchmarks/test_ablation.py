"""What is counted of a diagnosis with parts left out: right answers by variant, each case asked once."""

import json

import pytest

from benchmarks.diagnosis import ablation as of
from benchmarks.diagnosis import asked as asked_about
from benchmarks.diagnosis.ablation import COLUMNS, ablation
from sim1.stage import BadInput


def folder(tmp_path, name, *effects):
    path = tmp_path / name
    (path / "bundle").mkdir(parents=True)
    listed = [{"name": effect, "parameters": {}, "named_by_format": effect != "magnet"} for effect in effects]
    case = {"effects": list(effects), "strength": "medium", "seed": 1}
    answers = {"case": case, "effects": listed, "baseline": {}, "places_given": True}
    (path / "answers.json").write_text(json.dumps(answers))
    return path


def test_right_answers_are_counted_by_variant_and_no_case_is_asked_twice(tmp_path, monkeypatch):
    says = {
        "drag": ("named", ("air_drag",)),
        "strange": ("unknown", ()),
        "nothing": ("none", ()),
    }
    asked = []

    def said(name):
        asked.append(name)
        return dict.fromkeys(COLUMNS, says[name]) | {"screening alone": ("named", ("air_drag",))}

    monkeypatch.setattr(asked_about, "read_bundle", lambda path: path.parent.name)
    monkeypatch.setattr(of, "_said", said)
    folders = [folder(tmp_path, "drag", "air_drag"), folder(tmp_path, "strange", "magnet"), folder(tmp_path, "nothing")]
    for _ in range(2):
        table = ablation(folders, tmp_path / "out", lambda line: None).splitlines()
    assert asked == ["drag", "strange", "nothing"]
    assert table[2].startswith("| air_drag | named air_drag |")
    assert table[-1] == "| right | 3 of 3 | 3 of 3 | 3 of 3 | 1 of 3 | 3 of 3 |"
    assert table[-2].count("(wrong)") == 1


def test_a_case_without_answers_is_told_before_any_is_diagnosed(tmp_path, monkeypatch):
    monkeypatch.setattr(asked_about, "read_bundle", lambda path: pytest.fail("diagnosed"))
    (tmp_path / "bare").mkdir()
    with pytest.raises(BadInput, match=r"bare/answers\.json: not readable as answers"):
        ablation([folder(tmp_path, "drag", "air_drag"), tmp_path / "bare"], tmp_path / "out", lambda line: None)
