"""Cases that were scored on another machine: they count as they were scored there, where that fits what was drawn and committed to."""

import re
import shutil

import pytest
from proof_stand_ins import campaign, notes

from sim1.proof.draw import Case
from sim1.proof.files import Files
from sim1.proof.oracle import ask_oracle
from sim1.proof.prove import prove
from sim1.proof.report import rewrite
from sim1.stage import BadInput

DRAG = Case(effects=("air_drag",), seed=1)
NULL = Case(effects=(), seed=3)
STRANGE = Case(effects=("magnet",), seed=4)


def test_a_campaign_goes_on_elsewhere_with_its_small_files_alone(tmp_path):
    """Films and findings stay behind; how their cases were scored comes along and is told to be no check of the answers."""
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    first = prove(campaign(here, (DRAG, NULL, STRANGE)))
    for folder in ("outcomes", "records"):
        shutil.copytree(here / "out" / folder, there / "out" / folder)
    (there / "out" / "answers").mkdir()
    for file in ("answers/drawn.json", "commitments.jsonl"):
        shutil.copy(here / "out" / file, there / "out" / file)
    for folder in ("outcomes", "records"):
        (there / "out" / folder / "case_003.json").unlink()  # not done yet
    proof = prove(campaign(there, ()))
    assert proof.carried == ("case_001", "case_002")
    assert len(notes(there, "diagnosis")) == 1
    assert proof.outcomes[:2] == first.outcomes[:2]
    assert proof.totals.named == first.totals.named
    assert [one.right for one in proof.outcomes] == [True, True, True]
    assert "case_001, case_002" in (there / "out" / "proof.html").read_text()
    ask_oracle(Files(there / "out"), proof.outcomes, lambda line: pytest.fail(f"asked without a film: {line}"))


def test_an_outcome_that_came_without_its_record_is_told_and_stays(tmp_path):
    """Diagnosed anew, the case would be written over by what another machine finds."""
    work = campaign(tmp_path, (DRAG, NULL))
    prove(work)
    outcome = work.files.outcome("case_001")
    before = outcome.read_bytes()
    work.files.record("case_001").unlink()
    with pytest.raises(BadInput, match=r"outcomes/case_001.json: case_001 was scored, .* bring that file"):
        prove(campaign(tmp_path, ()))
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert "does not say that it was diagnosed" in proof.not_scored[0].why
    assert outcome.read_bytes() == before
    assert len(notes(tmp_path, "diagnosis")) == 2
    outcome.unlink()
    proof = prove(campaign(tmp_path, ()))
    assert proof.diagnosed.again == ("case_001",)
    assert "Diagnosed again after its end</strong>: case_001" in (work.files.root / "proof.html").read_text()


def test_a_damaged_outcome_or_record_is_told_and_the_others_count(tmp_path):
    work = campaign(tmp_path, (DRAG, NULL, STRANGE))
    prove(work)
    for path in work.files.root.glob("answers/case_*"):
        path.unlink()
    work.files.outcome("case_001").write_text("{")
    work.files.record("case_002").write_text("{")
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_003"]
    assert [one.why.split(": ")[0].split("/")[-2:] for one in proof.not_scored] == [
        ["outcomes", "case_001.json"],
        ["records", "case_002.json"],
    ]


CARRIED = {
    "called right": (lambda folder: swapped(folder / "outcomes/case_001.json", '"right":true', '"right":false'), "does not follow"),
    "of another seed": (lambda folder: swapped(folder / "outcomes/case_001.json", '"seed":1', '"seed":8'), "drawn was"),
    "of another kind": (lambda folder: swapped(folder / "outcomes/case_001.json", '"kind":"single"', '"kind":"outside"'), "it is single"),
    "never committed to": (lambda folder: swapped(folder / "commitments.jsonl", '"of":"case_001"', '"of":"case_009"'), "nobody committed"),
}  # fmt: skip


def swapped(path, old, new):
    """Whatever spaces stand around the colon."""
    text, count = re.subn(re.escape(old).replace(":", r":\s*"), new, path.read_text())
    assert count, f"{path} has no {old}: {text}"
    path.write_text(text)


@pytest.mark.parametrize("wrong", CARRIED)
def test_a_stored_outcome_that_does_not_fit_what_was_drawn_and_committed_to_counts_nowhere(tmp_path, wrong):
    do, word = CARRIED[wrong]
    prove(campaign(tmp_path, (DRAG, NULL)))
    for path in (tmp_path / "out" / "answers").glob("case_*"):
        path.unlink()
    assert prove(campaign(tmp_path, ())).carried == ("case_001", "case_002")
    do(tmp_path / "out")
    proof = prove(campaign(tmp_path, ()))
    assert proof.carried == ("case_002",)
    [left] = proof.not_scored
    assert left.case == "case_001"
    assert word in left.why
