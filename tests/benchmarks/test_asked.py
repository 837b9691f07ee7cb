"""Answers of a benchmark are kept by case, and never taken for those to another question or of another film."""

import json

import pytest

from benchmarks.diagnosis import asked
from benchmarks.diagnosis.asked import each_once
from sim1.stage import BadInput


def folder(root, name, effect="wind", film=b"markers"):
    path = root / name
    (path / "bundle").mkdir(parents=True)
    (path / "bundle" / "markers.parquet").write_bytes(film)
    listed = [{"name": effect, "parameters": {}, "named_by_format": True}]
    case = {"effects": [effect], "strength": "medium", "seed": 1}
    (path / "answers.json").write_text(
        json.dumps({"case": case, "effects": listed, "baseline": {}, "places_given": True})
    )
    return path


@pytest.fixture(autouse=True)
def names_alone(monkeypatch):
    monkeypatch.setattr(asked, "read_bundle", lambda path: path.parent.name)


def ask(folders, out, what="length"):
    return [found for _, found in each_once(folders, out, what, len, lambda line: None)]


def test_an_answer_that_is_there_is_given_again(tmp_path):
    case = folder(tmp_path, "one")
    assert ask([case], tmp_path / "out") == [3]
    path = tmp_path / "out" / "one.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"found": 8}))
    assert ask([case], tmp_path / "out") == [8]


def test_an_answer_to_another_question_is_refused_before_any_case_is_asked(tmp_path):
    first, second = folder(tmp_path, "first"), folder(tmp_path, "second")
    ask([second], tmp_path / "out")
    with pytest.raises(BadInput, match=r"second.json is of .*length.*; give another folder for --out, or remove it"):
        ask([first, second], tmp_path / "out", what="width")
    assert not (tmp_path / "out" / "first.json").exists()


def test_an_answer_about_another_film_is_refused(tmp_path):
    """Cases of all campaigns have the same names."""
    ask([folder(tmp_path / "a", "case_001")], tmp_path / "out")
    with pytest.raises(BadInput, match=r"case_001.json is of"):
        ask([folder(tmp_path / "b", "case_001", film=b"others")], tmp_path / "out")


def test_two_cases_of_one_name_are_refused(tmp_path):
    with pytest.raises(BadInput, match="another case is called case_001 too"):
        ask([folder(tmp_path / name, "case_001") for name in ("a", "b")], tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("text", ["{", "[]", '{"true": {}}'])
def test_a_file_that_is_no_answer_is_named(tmp_path, text):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "one.json").write_text(text)
    with pytest.raises(BadInput, match=r"one.json: not what a benchmark keeps"):
        ask([folder(tmp_path, "one")], tmp_path / "out")
