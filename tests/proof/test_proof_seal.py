"""Commitments: what was told before cannot be changed afterwards unnoticed."""

import hashlib
import json

import pytest

from sim1.proof.seal import check_committed, commit, read_commitments
from sim1.stage import BadInput


@pytest.fixture
def sealed(tmp_path):
    """A folder with an answer that was committed to."""
    (tmp_path / "answers").mkdir()
    answer = tmp_path / "answers" / "case_001.json"
    answer.write_text("air_drag")
    commit(tmp_path, "case_001", [answer], "c0de")
    return tmp_path, answer


def test_the_hash_is_that_of_sha256sum(sealed):
    root, answer = sealed
    (line,) = read_commitments(root)
    assert line.sha256 == {"answers/case_001.json": hashlib.sha256(b"air_drag").hexdigest()}
    assert (line.of, line.code_sha256) == ("case_001", "c0de")
    check_committed(root, "case_001", [answer])


def test_a_changed_answer_is_found_and_named(sealed):
    root, answer = sealed
    answer.write_text("wind")
    with pytest.raises(BadInput, match=r"case_001\.json: changed since it was committed to"):
        check_committed(root, "case_001", [answer])
    with pytest.raises(BadInput, match=r"case_001\.json: changed since"):
        commit(root, "case_001", [answer], "c0de")
    answer.unlink()
    with pytest.raises(BadInput, match=r"case_001\.json: committed to at .* and gone"):
        check_committed(root, "case_001", [answer])


def test_committing_again_to_the_same_adds_nothing(sealed):
    root, answer = sealed
    first = (root / "commitments.jsonl").read_bytes()
    commit(root, "case_001", [answer], "other")
    assert (root / "commitments.jsonl").read_bytes() == first


def test_a_file_that_nobody_committed_to_and_a_damaged_line_are_errors(sealed):
    root, answer = sealed
    other = answer.with_name("case_002.json")
    other.write_text("wind")
    for of, files in (("case_002", [other]), ("case_001", [answer, other])):
        with pytest.raises(BadInput, match="holds no commitment to it"):
            check_committed(root, of, files)
    with (root / "commitments.jsonl").open("a") as file:
        file.write('{"at": "2026')
    with pytest.raises(BadInput, match="line 2 is damaged"):
        read_commitments(root)


def test_a_line_that_was_changed_or_taken_out_is_told_by_the_one_after_it(sealed):
    root, answer = sealed
    other = answer.with_name("case_002.json")
    other.write_text("wind")
    commit(root, "case_002", [other], "c0de", "lab")
    path = root / "commitments.jsonl"
    first, second = path.read_bytes().splitlines(keepends=True)
    one, two = read_commitments(root)
    assert (one.before, two.before) == (None, hashlib.sha256(first).hexdigest())
    assert (one.laboratory_sha256, two.laboratory_sha256) == (None, "lab")
    path.write_bytes(second)
    with pytest.raises(BadInput, match=r"line 1 was added to a line of SHA-256 .* before it stands none"):
        read_commitments(root)
    path.write_bytes(first.replace(b"c0de", b"code") + second)
    with pytest.raises(BadInput, match=r"line 2 was added to a line of SHA-256 .* were changed or taken out"):
        read_commitments(root)


def test_lines_of_earlier_code_hold_no_hash_and_the_first_one_after_them_does(sealed):
    root, answer = sealed
    path = root / "commitments.jsonl"
    early = json.loads(path.read_text())
    del early["before"], early["laboratory_sha256"]
    path.write_text(json.dumps(early) + "\n")
    other = answer.with_name("case_002.json")
    other.write_text("wind")
    commit(root, "case_002", [other], "c0de")
    assert read_commitments(root)[1].before == hashlib.sha256((json.dumps(early) + "\n").encode()).hexdigest()
