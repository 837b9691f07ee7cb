"""What is counted of a diagnosis with parts left out: right answers by variant and kind, each case asked once."""

import json

import pytest

from benchmarks.diagnosis import ablation as of
from benchmarks.diagnosis import asked as asked_about
from benchmarks.diagnosis.ablation import COLUMNS, ablation
from sim1.stage import BadInput


def folder(tmp_path, name, *effects, strength="medium"):
    path = tmp_path / name
    (path / "bundle").mkdir(parents=True)
    listed = [{"name": effect, "parameters": {}, "named_by_format": effect != "magnet"} for effect in effects]
    case = {"effects": list(effects), "strength": strength, "seed": 1}
    answers = {"case": case, "effects": listed, "baseline": {}, "places_given": True}
    (path / "answers.json").write_text(json.dumps(answers))
    return path


def test_right_answers_are_counted_by_variant_and_kind_and_no_case_is_asked_twice(tmp_path, monkeypatch):
    says = {
        "drag": ("named", ("air_drag",), 20.0),
        "strange": ("unknown", (), 40.0),
        "nothing": ("none", (), 10.0),
        "two": ("named", ("air_drag", "wind"), 90.0),
    }
    asked = []

    def said(name):
        asked.append(name)
        return dict.fromkeys(COLUMNS, says[name]) | {"screening alone": ("named", ("air_drag",), 3.0)}

    monkeypatch.setattr(asked_about, "read_bundle", lambda path: path.parent.name)
    monkeypatch.setattr(of, "with_parts_left_out", said)
    folders = [
        folder(tmp_path, "drag", "air_drag"),
        folder(tmp_path, "strange", "magnet"),
        folder(tmp_path, "nothing"),
        folder(tmp_path, "two", "wind", "air_drag"),
    ]
    for _ in range(2):
        table = ablation(folders, tmp_path / "out", lambda line: None).splitlines()
    assert asked == ["drag", "strange", "nothing", "two"]
    assert table[0] == (
        "| concealed | whole | nothing measured | not orthogonal | screening alone | fit error alone | no veto |"
    )
    assert table[2].startswith("| air_drag | named air_drag |")
    assert "| named air_drag (wrong) |" in table[5]
    assert table[6:] == [
        "| right, one effect | 1 of 1 | 1 of 1 | 1 of 1 | 1 of 1 | 1 of 1 | 1 of 1 |",
        "| right, nothing | 1 of 1 | 1 of 1 | 1 of 1 | 0 of 1 | 1 of 1 | 1 of 1 |",
        "| right, outside the table | 1 of 1 | 1 of 1 | 1 of 1 | 0 of 1 | 1 of 1 | 1 of 1 |",
        "| right, two effects | 1 of 1 | 1 of 1 | 1 of 1 | 0 of 1 | 1 of 1 | 1 of 1 |",
        "| right, all | 4 of 4 | 4 of 4 | 4 of 4 | 1 of 4 | 4 of 4 | 4 of 4 |",
        "| seconds, median | 30 | 30 | 30 | 3 | 30 | 30 |",
    ]


def test_silence_about_a_weak_effect_is_no_wrong_answer(tmp_path, monkeypatch):
    monkeypatch.setattr(asked_about, "read_bundle", lambda path: path.parent.name)
    monkeypatch.setattr(of, "with_parts_left_out", lambda name: dict.fromkeys(COLUMNS, ("none", (), 10.0)))
    folders = [folder(tmp_path, "drag", "air_drag", strength="weak"), folder(tmp_path, "nothing")]
    table = ablation(folders, tmp_path / "out", lambda line: None)
    assert "| air_drag | none (weak, not counted) |" in table
    assert "right, one effect" not in table
    assert "| right, all | 1 of 1 |" in table


def test_a_kind_that_no_case_is_of_has_no_line(tmp_path, monkeypatch):
    monkeypatch.setattr(asked_about, "read_bundle", lambda path: None)
    monkeypatch.setattr(of, "with_parts_left_out", lambda bundle: dict.fromkeys(COLUMNS, ("none", (), 1.0)))
    table = ablation([folder(tmp_path, "nothing")], tmp_path / "out", lambda line: None)
    assert "right, nothing" in table
    assert "right, two effects" not in table


def test_a_case_without_answers_is_told_before_any_is_diagnosed(tmp_path, monkeypatch):
    monkeypatch.setattr(asked_about, "read_bundle", lambda path: pytest.fail("diagnosed"))
    (tmp_path / "bare").mkdir()
    with pytest.raises(BadInput, match=r"bare/answers\.json: not readable as answers"):
        ablation([folder(tmp_path, "drag", "air_drag"), tmp_path / "bare"], tmp_path / "out", lambda line: None)
