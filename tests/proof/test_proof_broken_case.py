"""Whose fault it is: a diagnosis that fails is wrong whatever it leaves, answers that are damaged count nowhere, and the others go on."""

import json
import re

import numpy as np
import pandas as pd
import pytest
from proof_stand_ins import DRAG, NULL, SHRUNK, campaign, lines_of, unsealed, write_lines

from sim1.proof.ledger import hashes
from sim1.proof.prove import prove
from sim1.proof.report import rewrite, scored


def made(folder, cases=(DRAG, NULL), diagnosis=None, prediction=None):
    """A campaign that is done, with other programs where they are given."""
    work = campaign(folder, cases)
    for name, change in (("diagnosis", diagnosis), ("prediction", prediction)):
        program = folder / f"{name}.py"
        program.write_text(program.read_text() if change is None else change(program.read_text()))
    return work, prove(work)


def test_a_diagnosis_that_fails_is_wrong_though_it_leaves_a_file_in_its_bundle(tmp_path):
    def leaving(text):
        return text.replace(
            '    sys.exit("it shrank', '    (bundle / "core").write_text("dumped")\n    sys.exit("it shrank'
        )

    _, proof = made(tmp_path, (SHRUNK, NULL), diagnosis=leaving)
    assert (tmp_path / "out/bundles/case_001/core").is_file()
    assert [(one.verdict, one.right) for one in proof.outcomes] == [("failed", False), ("none", True)]


def test_what_a_diagnosis_leaves_where_it_stands_is_in_no_film(tmp_path):
    work, proof = made(tmp_path, diagnosis=lambda text: text + 'pathlib.Path("core").write_text("dumped")\n')
    assert [one.right for one in proof.outcomes] == [True, True]
    assert not list(work.files.root.rglob("core"))


def committed_anew(work, case):
    """Commit to answers and films as they are now: as a laboratory would have that wrote them so."""
    lines = lines_of(work.files.root)
    for line in lines:
        if line.get("of") == case:
            line["sha256"] = hashes(work.files.root, work.files.sealed(case))
    write_lines(work.files.root, lines)


ANSWERS = {
    "no stamps": ({"a/stamps_s": None}, r"case_001.npz: .*no array 'a/stamps_s'.*; film the case again"),
    "no force": ({"a/missing_n_m2": None}, r"case_001.npz: .*no array 'a/missing_n_m2'.*; film the case again"),
    "neither": ({"a/stamps_s": None, "a/missing_n_m2": None}, r"case_001.npz: .*no array 'NAME/stamps_s' of any"),
    "not finite": ({"a/missing_n_m2": np.full((4, 4), np.nan)}, r"array 'a/missing_n_m2' is nan at \(0, 0\)"),
    "too few": ({"a/stamps_s": np.arange(3.0)}, r"array 'a/missing_n_m2' is \(4, 4\), expected \(3, "),
}


@pytest.mark.parametrize("harm", ANSWERS)
def test_answers_without_a_course_are_told_and_the_diagnosis_is_not_blamed(work, harm):
    change, said = ANSWERS[harm]
    path = work.files.answers("case_001").with_suffix(".npz")
    arrays = dict(np.load(path)) | change
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    committed_anew(work, "case_001")
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert re.search(said, proof.not_scored[0].why), proof.not_scored[0].why


def test_a_recording_that_was_filmed_must_be_in_the_answers(work):
    film = work.files.bundle("case_001") / "recordings" / "b" / "markers.parquet"
    film.parent.mkdir(parents=True)
    film.write_text("")
    committed_anew(work, "case_001")
    assert "no array 'b/stamps_s'" in rewrite(work.files).not_scored[0].why


def test_answers_that_hold_no_number_where_one_is_due_are_told(work):
    path = work.files.answers("case_001")
    path.write_text(path.read_text().replace("300.0", "NaN"))
    committed_anew(work, "case_001")
    why = rewrite(work.files).not_scored[0].why
    assert "case_001.json: not readable as answers" in why
    assert "baseline.stretch_n_m" in why


FORCES = {
    "another recording": (
        lambda arrays: {name.replace("a/", "b/"): array for name, array in arrays.items()},
        "b/force_n has 4 markers, the answers have nothing of it",
    ),
    "other markers": (
        lambda arrays: arrays | {"a/force_n": np.ones((4, 3, 3))},
        "a/force_n has 3 markers, the answers have 4 markers of it",
    ),
    "not finite": (lambda arrays: arrays | {"a/force_n": np.full((4, 4, 3), np.nan)}, "is nan at (0, 0, 0)"),
    "no instant": (lambda arrays: {"a/time_s": np.zeros(0), "a/force_n": np.zeros((0, 4, 3))}, "is of no instant"),
}


@pytest.mark.parametrize("harm", FORCES)
def test_forces_that_cannot_be_set_against_the_answers_are_a_failed_diagnosis(work, harm):
    change, said = FORCES[harm]
    unsealed(work.files.root)
    path = work.files.found("case_001") / "forces.npz"
    np.savez(path, **change(dict(np.load(path))))
    first, second = rewrite(work.files).outcomes
    assert (first.verdict, first.right, second.right) == ("failed", False, True)
    assert "case_001/forces.npz: " in first.error
    assert said in first.error


def test_a_place_that_is_not_finite_in_what_was_foretold_is_told_and_the_others_are_scored(work):
    unsealed(work.files.root)
    path = work.files.foretold("case_001", "model")
    table = pd.read_parquet(path)
    table.loc[3, "y_m"] = np.nan
    table.to_parquet(path)
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    said = r"case_001/model.parquet: .*u: y_m of the marker in place 1 at 0.017 s is nan, in the answers 0.0\); bring the file"
    assert re.search(said, proof.not_scored[0].why), proof.not_scored[0].why


def test_errors_that_are_not_known_are_told_in_words_where_no_reason_was_kept(work):
    """As in a campaign of earlier code; a figure that is missing must not stop the page either."""
    unsealed(work.files.root)
    for case, lost in (("case_001", ("augmented",)), ("case_002", ("baseline", "augmented"))):
        path = work.files.found(case) / "verdict.json"
        verdict = json.loads(path.read_text())
        for side in lost:
            verdict["rmse_m"][side] = {"fit": None, "heldout": None}
        path.write_text(json.dumps(verdict))
    proof = rewrite(work.files)
    assert proof.totals.heldout_worse == proof.totals.heldout_lost == ("case_001",)
    page = (work.files.root / "proof.html").read_text()
    assert "2.00 &rarr;\n<strong>no simulation with what was named</strong></td>" in page
    assert "no simulation &rarr;\nnone</td>" in page
    assert "?" not in page.split("<h2>Case by case</h2>")[1].split("<h2>")[0]


def test_a_model_that_foretells_nothing_is_listed_with_the_reason(tmp_path):
    def lost(text):
        return text.replace(
            "off_m = 0.004",
            'if model.name == "model.yaml" and "air_drag" in (unseen / "bundle.yaml").read_text():\n    sys.exit("no next state at 0.7 s")\noff_m = 0.004',
        )

    work, proof = made(tmp_path, prediction=lost)
    first = proof.outcomes[0]
    assert first.unseen_mm == (pytest.approx(4.0), None)
    assert proof.totals.unseen_worse == proof.totals.unseen_lost == ("case_001",)
    assert "no next state at 0.7 s" in first.not_foretold["model"]
    page = (work.files.root / "proof.html").read_text()
    assert "<td>case_001 (no simulation with what was named)</td>" in page
    assert "<strong>no simulation with what was named</strong>: ended with 1: no next state at 0.7 s" in page
    assert "no simulation in half of them or more" in page


def test_a_campaign_that_is_only_asked_for_its_score_is_left_as_it_is(work):
    """Thresholds are calibrated with the cases of campaigns on which other processes may be at work."""
    unsealed(work.files.root)
    gone, harmed = work.files.outcome("case_001"), work.files.outcome("case_002")
    gone.unlink()
    harmed.write_text("{")
    before = {path: path.stat().st_mtime_ns for path in work.files.root.rglob("*")}
    assert [one.case for one in scored(work.files).outcomes] == ["case_001", "case_002"]
    assert {path: path.stat().st_mtime_ns for path in work.files.root.rglob("*")} == before
    rewrite(work.files)
    assert gone.is_file()
