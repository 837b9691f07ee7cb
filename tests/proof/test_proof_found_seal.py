"""What was found is sealed when a diagnosis ends: changed afterwards it counts nowhere, and had by trying again it is told."""

import hashlib
import json
import re

import pytest
from proof_stand_ins import DRAG, NULL, SHRUNK, campaign, lines_of, unsealed, write_lines

from sim1.proof.found_seal import diagnosed
from sim1.proof.ledger import Begun, Ended, read_lines
from sim1.proof.prove import prove
from sim1.proof.report import rewrite


def begun(case):
    return Begun(at="now", begun=case, code_sha256="c0de")


def ended(case):
    return Ended(at="now", ended=case, seconds=1.0, error=None, code_sha256="c0de", sha256={})


def test_every_file_that_was_found_or_foretold_is_in_the_line_of_its_end(tmp_path):
    said = []
    work = campaign(tmp_path, (DRAG, SHRUNK), said.append)
    prove(work)
    first, failed = (line for line in read_lines(work.files.root) if isinstance(line, Ended))
    names = {"verdict.json", "summary.json", "model.yaml", "baseline.yaml", "forces.npz", "report.html", "diagnose.log"}
    foretold = {f"foretold/case_001/{model}.parquet" for model in ("baseline", "model")}
    assert set(first.sha256) == {f"found/case_001/{name}" for name in names} | foretold
    assert "it shrank to nothing" in failed.error
    assert (failed.ended, failed.sha256) == ("case_002", {})
    lines = (work.files.root / "commitments.jsonl").read_text().splitlines(keepends=True)
    for line in (line for line in lines if "ended" in json.loads(line)):  # as grep and sha256sum find it
        hashed = hashlib.sha256(line.encode()).hexdigest()
        told = f"{json.loads(line)['ended']}: what was found is sealed; SHA-256 of that line of commitments.jsonl: {hashed}"
        assert told in said


HARM = {
    "changed": (lambda root: (root / "found/case_001/verdict.json").write_text("{}"), r"found/case_001/verdict.json: changed since it was sealed at"),
    "gone": (lambda root: (root / "foretold/case_001/model.parquet").unlink(), r"foretold/case_001/model.parquet: sealed at .* and gone"),
    "added": (lambda root: (root / "found/case_001/more").write_text(""), r"found/case_001/more: came after the others were sealed"),
    "called failed": (lambda root: _rewritten(root / "records/case_001.json", error="it broke"), r"records/case_001.json: says .* error 'it broke'.* sealed at .* error None"),
    "without its end": (lambda root: _without_end(root), r"commitments.jsonl: case_001 began to be diagnosed at .* nothing says that it ended"),
}  # fmt: skip


def _rewritten(path, **fields):
    path.write_text(json.dumps(json.loads(path.read_text()) | fields))


def _without_end(root):
    write_lines(root, [line for line in lines_of(root) if line.get("ended") != "case_001"])


@pytest.mark.parametrize("harm", HARM)
def test_what_was_found_and_is_no_longer_what_was_sealed_is_named_and_the_case_not_scored(work, harm):
    do, said = HARM[harm]
    do(work.files.root)
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    [left] = proof.not_scored
    assert left.case == "case_001"
    assert re.search(said, left.why), left.why


def test_a_campaign_of_earlier_code_is_scored_and_told_to_be_without_seals(tmp_path):
    work = campaign(tmp_path, (DRAG, NULL))
    assert prove(work).diagnosed.unsealed == ()
    assert "is not sealed" not in (work.files.root / "proof.html").read_text()
    unsealed(work.files.root)
    proof = rewrite(work.files)
    assert proof.diagnosed.unsealed == tuple(one.case for one in proof.outcomes) == ("case_001", "case_002")
    assert (
        "<strong>What was found is not sealed</strong> in case_001, case_002"
        in (work.files.root / "proof.html").read_text()
    )


def test_a_second_beginning_is_told_by_whether_an_end_lies_before_it():
    lines = [
        begun("a"),
        ended("a"),
        begun("b"),
        begun("b"),
        ended("b"),
        begun("c"),
        ended("c"),
        begun("c"),
        ended("c"),
        begun("d"),
    ]
    told = diagnosed(lines, ["a", "b", "c", "old"])
    assert (told.unsealed, told.begun_twice, told.again) == (("old",), ("b",), ("c",))
    both = diagnosed([begun("a"), ended("a"), begun("a"), begun("a"), ended("a")], ["a"])
    assert (both.begun_twice, both.again) == (("a",), ("a",))
