"""A small proof with nothing made up: the laboratory films, the diagnosis diagnoses, each in processes of its own, and all is scored."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.proof.fresh import null_seeds

NOTHING, DRAG, STRANGE = (
    {"effects": ["none"], "seed": 101},
    {"effects": ["air_drag"], "strength": "strong", "seed": 102},
    {"effects": ["hidden_thread"], "strength": "strong", "seed": 103},
)
pytestmark = pytest.mark.timeout(3600)  # whichever test comes first has everything filmed and diagnosed
CASES = ("case_001", "case_002", "case_003")


@pytest.fixture(scope="module")
def proved(tmp_path_factory):
    """Folder of a campaign of three chosen cases, and what was printed; about ten minutes of a core."""
    folder = tmp_path_factory.mktemp("proof")
    (folder / "cases.yaml").write_text(json.dumps([NOTHING, DRAG, STRANGE]))
    words = ["prove", "--cases-file", str(folder / "cases.yaml"), "--out", str(folder / "out")]
    said = CliRunner().invoke(app, words)
    assert said.exit_code == 0, said.output
    return folder / "out", said.output


def lines_of(root: Path) -> list[dict]:
    return [json.loads(line) for line in (root / "commitments.jsonl").read_text().splitlines()]


def outcomes_of(root: Path) -> list[dict]:
    return json.loads((root / "proof.json").read_text())["outcomes"]


def test_its_null_is_none_by_which_thresholds_were_set():
    assert NOTHING["seed"] not in null_seeds()


@pytest.mark.slow
def test_answers_and_films_are_committed_to_before_each_diagnosis_and_what_it_found_after_it(proved):
    root, printed = proved
    lines = lines_of(root)
    assert lines[0]["of"] == "list"
    for case in CASES:
        order = [next(iter(line.keys() & {"of", "begun", "ended"})) for line in lines if case in line.values()]
        assert order == ["of", "begun", "ended"]
        (committed,) = [line for line in lines if line.get("of") == case]
        names = set(committed["sha256"])
        assert {f"answers/{case}.json", f"answers/{case}.npz", f"bundles/{case}/bundle.yaml"} < names
        assert f"unseen/{case}/bundle.yaml" in names
        (ended,) = [line for line in lines if line.get("ended") == case]
        assert f"found/{case}/verdict.json" in ended["sha256"]
        assert f"{case}: committed at" in printed


@pytest.mark.slow
def test_every_verdict_is_scored_nothing_is_called_nothing_and_the_strong_drag_is_named_with_its_coefficient(proved):
    root, printed = proved
    null, drag, strange = outcomes_of(root)
    proof = json.loads((root / "proof.json").read_text())
    assert (proof["not_scored"], proof["of_thresholds"], proof["one_code"]) == ([], [], True)
    assert [one["kind"] for one in (null, drag, strange)] == ["null", "single", "outside"]
    assert (null["verdict"], null["right"]) == ("none", True)
    assert (drag["verdict"], drag["named"], drag["strength"]) == ("named", ["air_drag"], "strong")
    coefficient = drag["found"]["effects"]["air_drag"]["c_normal"]
    assert coefficient["true"] == drag["concealed"]["air_drag"]["c_normal"]
    assert coefficient["value"] == pytest.approx(coefficient["true"], rel=0.3)
    assert drag["unseen_mm"][1] < 0.8 * drag["unseen_mm"][0]
    assert strange["verdict"] in ("none", "unknown", "ambiguous", "named")  # right or wrong, it came to an end
    assert strange["right"] == (strange["verdict"] in ("unknown", "ambiguous"))
    assert proof["totals"]["by_strength"]["strong"]["named"]["count"] == 1
    assert "one effect, strong: named right 1 of 1" in printed
    assert (root / "proof.html").is_file()
