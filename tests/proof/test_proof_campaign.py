"""A campaign with a laboratory and a diagnosis of a few lines: order, blindness, resumption, failures."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from datetime import datetime
from pathlib import Path

import pandas as pd
import pytest
from proof_stand_ins import DRAG, LAME, NULL, PAIR, SHRUNK, STRANGE, campaign, films, notes, unsealed

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.summary import SCHEMA
from sim1.proof.files import Files
from sim1.proof.oracle import ask_oracle
from sim1.proof.proof import Proof
from sim1.proof.prove import prove
from sim1.proof.report import rewrite
from sim1.stage import BadInput


def test_what_is_concealed_is_named_scored_and_shown(tmp_path):
    said = []
    proof = prove(campaign(tmp_path, (DRAG, PAIR, NULL, STRANGE), said.append))
    assert [(one.kind, one.verdict, one.right) for one in proof.outcomes] == [
        ("single", "named", True),
        ("several", "named", True),
        ("null", "none", True),
        ("outside", "unknown", True),
    ]
    assert proof.one_code
    told = Proof.model_validate_json((tmp_path / "out" / "proof.json").read_text())
    assert told == proof
    assert told.totals.named.count == 1
    page = (tmp_path / "out" / "proof.html").read_text()
    assert 'href="found/case_001/report.html"' in page
    assert "adhesion + wind" in page
    assert [one.unseen_mm for one in proof.outcomes] == [
        (pytest.approx(4.0), pytest.approx(1.0)),
        (None, None),  # its prediction fails: not known, and no fault of the diagnosis
        (pytest.approx(4.0), pytest.approx(1.0)),
        (pytest.approx(4.0), pytest.approx(1.0)),
    ]
    assert "case_002: model.yaml foretells no motion: ended with 1: it sticks" in said
    assert any("case_001: named air_drag in" in line and "concealed was air_drag: right" in line for line in said)


def test_answers_are_committed_to_before_the_diagnosis_begins_and_the_list_before_the_first_film(tmp_path):
    work = campaign(tmp_path, (DRAG, NULL))
    lines = (tmp_path / "out" / "commitments.jsonl").read_text().splitlines()
    assert [json.loads(line)["of"] for line in lines] == ["list"]
    assert notes(tmp_path, "laboratory") == []
    said = []
    prove(campaign(tmp_path, (DRAG, NULL), said.append))
    order = [line.split(" at ")[0].split(" to ")[0] for line in said if line.startswith("case_001")]
    assert order[:3] == ["case_001: filming", "case_001: committed", "case_001: diagnosing"]
    lines = [json.loads(line) for line in (work.files.root / "commitments.jsonl").read_text().splitlines()]
    told = [key for line in lines for key in ("of", "begun", "ended") if key in line]
    assert told == ["of", *["of", "begun", "ended"] * 2]
    committed = [line for line in lines if "of" in line]
    assert [line["of"] for line in committed] == ["list", "case_001", "case_002"]
    for line, call in zip(committed[1:], notes(tmp_path, "diagnosis"), strict=True):
        assert datetime.fromisoformat(line["at"]).timestamp() <= call["at"]
        films = {f"{folder}/{line['of']}/bundle.yaml" for folder in ("bundles", "unseen")}
        films.add(f"unseen/{line['of']}/recordings/u/markers.parquet")
        assert set(line["sha256"]) == {f"answers/{line['of']}.json", f"answers/{line['of']}.npz"} | films


def test_the_diagnosis_is_given_the_bundle_alone_and_its_name_says_nothing(tmp_path):
    prove(campaign(tmp_path, (DRAG, STRANGE)))
    out = tmp_path / "out"
    for number, call in enumerate(notes(tmp_path, "diagnosis"), start=1):
        bundle = str(out / "bundles" / f"case_{number:03d}")
        assert call["argv"][:2] == [bundle, "--out"]
        assert call["argv"][2].startswith(str(out / "found" / f".case_{number:03d}."))
        assert not call["cwd"].startswith(str(out))  # an empty folder, of which no way leads to the answers
    assert [path.name for path in (out / "bundles" / "case_001").iterdir()] == ["bundle.yaml"]


def test_motions_that_the_diagnosis_is_not_given_are_foretold_by_both_of_its_models_afterwards(tmp_path):
    work = campaign(tmp_path, (DRAG,))
    prove(work)
    unseen, found = work.files.unseen("case_001"), work.files.found("case_001")
    diagnosis, *predictions = [line for line in notes(tmp_path) if line["who"] != "laboratory"]
    assert not any("unseen" in word for word in diagnosis["argv"])
    assert [(call["who"], call["argv"][:3]) for call in predictions] == [
        ("prediction", [str(unseen), "--model", str(found / f"{model}.yaml")]) for model in ("baseline", "model")
    ]


def test_a_second_name_that_motion_held_out_decided_for_is_marked_on_the_page_and_in_its_file(tmp_path):
    work = campaign(tmp_path, (PAIR, DRAG))
    proof = prove(work)
    assert [one.found.spoken_for for one in proof.outcomes] == [("adhesion",), ()]
    page = (work.files.root / "proof.html").read_text()
    assert "(adhesion by held-out motion)" in page
    assert "Not told of" not in page


def test_a_case_that_fails_is_recorded_with_its_cause_and_the_others_go_on(tmp_path):
    proof = prove(campaign(tmp_path, (LAME, SHRUNK, DRAG), parallel=2))
    assert [(one.case, one.verdict, one.right) for one in proof.outcomes] == [
        ("case_002", "failed", False),
        ("case_003", "named", True),
    ]
    assert "it shrank to nothing" in proof.outcomes[0].error
    assert "the jet would not start" in proof.not_scored[0].why
    assert (proof.totals.named.count, proof.totals.named.of, proof.totals.failed) == (1, 2, 1)
    assert "it shrank to nothing" in (tmp_path / "out" / "proof.html").read_text()
    prove(campaign(tmp_path, ()))
    assert len(notes(tmp_path, "laboratory")) == 4  # what was not filmed is tried again,
    assert len(notes(tmp_path, "diagnosis")) == 2  # what was not diagnosed is not: that would be choosing


def test_what_other_code_wrote_is_no_failed_diagnosis_and_its_score_is_kept(tmp_path):
    files = campaign(tmp_path, (DRAG,)).files
    prove(campaign(tmp_path, ()))
    unsealed(files.root)
    scored = files.outcome("case_001").read_bytes()
    summary = files.found("case_001") / "summary.json"
    summary.write_text(summary.read_text().replace(SCHEMA, "sim1.diagnosis/1"))
    with pytest.raises(BadInput, match=rf"summary\.json: schema sim1\.diagnosis/1, this code reads {SCHEMA}: score"):
        rewrite(files)
    assert files.outcome("case_001").read_bytes() == scored
    summary.write_text("{")
    [outcome] = rewrite(files).outcomes
    assert outcome.verdict == "failed"


def test_a_killed_campaign_goes_on_and_does_nothing_twice(tmp_path):
    cases = (DRAG, NULL, STRANGE)
    work = campaign(tmp_path, cases)
    (tmp_path / "slow").touch()
    program = (
        f"import sys; sys.path[:0] = [{str(Path(__file__).parent)!r}]; from pathlib import Path; from proof_stand_ins import campaign\n"
        "from sim1.proof.prove import prove; from sim1.proof.draw import Case\n"
        f"prove(campaign(Path({str(tmp_path)!r}), ()))"
    )
    running = subprocess.Popen([sys.executable, "-c", program], cwd=Path(__file__).parents[2])
    _until(lambda: len(notes(tmp_path, "diagnosis")) == 1)
    running.send_signal(signal.SIGKILL)
    running.wait()
    assert not work.files.record("case_001").exists()
    (tmp_path / "slow").unlink()
    committed = (tmp_path / "out" / "commitments.jsonl").read_bytes()
    assert len(committed.splitlines()) == 3  # list, case, and that its diagnosis begins
    proof = prove(campaign(tmp_path, ()))
    assert [one.right for one in proof.outcomes] == [True, True, True]
    assert (proof.diagnosed.begun_twice, proof.diagnosed.again) == (("case_001",), ())
    page = (tmp_path / "out" / "proof.html").read_text()
    assert "Begun twice: an interrupted one, or one that was tried again: case_001." in page
    assert len(notes(tmp_path, "laboratory")) == 3
    assert len(notes(tmp_path, "diagnosis")) == 4  # the one that was cut off began anew
    assert (tmp_path / "out" / "commitments.jsonl").read_bytes().startswith(committed)
    again = prove(campaign(tmp_path, ()))
    assert again == proof
    assert len(notes(tmp_path, "diagnosis")) == 4
    assert not list((tmp_path / "out").rglob("*.part"))


def test_a_diagnosis_that_outlived_its_campaign_and_still_writes_holds_nothing_up(tmp_path, monkeypatch):
    work = campaign(tmp_path, (DRAG,))
    scratch = work.files.found(".case_001.1")
    scratch.mkdir(parents=True)
    (scratch / "noted.json").touch()
    remove = os.rmdir

    def written_to_first(path, **places):
        if scratch.is_dir():
            (scratch / "written_meanwhile.json").touch()
        remove(path, **places)

    monkeypatch.setattr("os.rmdir", written_to_first)
    assert [one.right for one in prove(work).outcomes] == [True]
    monkeypatch.undo()
    prove(campaign(tmp_path, ()))
    assert [path.name for path in scratch.parent.iterdir()] == ["case_001"]


def test_an_interruption_ends_the_diagnosis_and_leaves_no_verdict_of_half_a_search(tmp_path):
    (tmp_path / "slow").touch()

    def interrupt(line):
        if "diagnosing" in line:
            work.processes.stop()

    work = campaign(tmp_path, (DRAG,), interrupt)
    with pytest.raises(RuntimeError):
        prove(work)
    assert not work.files.record("case_001").exists()
    (tmp_path / "slow").unlink()
    assert prove(campaign(tmp_path, ())).outcomes[0].right


def test_a_case_whose_films_stayed_behind_is_filmed_again_as_it_was_committed_to(tmp_path):
    work = campaign(tmp_path, (DRAG, NULL))
    prove(work, only_films=True)
    for path in (work.files.bundle("case_001"), work.files.unseen("case_001")):
        shutil.rmtree(path)
    for path in work.files.answers("case_001").parent.glob("case_001.*"):
        path.unlink()
    proof = prove(campaign(tmp_path, ()))
    assert [one.right for one in proof.outcomes] == [True, True]
    assert len(notes(tmp_path, "laboratory")) == 3


def test_what_is_still_to_come_is_not_told(tmp_path):
    prove(campaign(tmp_path, (DRAG, NULL)), only_films=True)
    for name in ("proof.json", "proof.html", "commitments.jsonl"):
        assert "drag" not in (tmp_path / "out" / name).read_text()


def test_code_that_changes_during_the_campaign_is_told(tmp_path):
    prove(campaign(tmp_path, (DRAG, NULL)), only_films=True)
    code = tmp_path / "code" / "sim1" / "mismatch" / "a.py"
    first = rewrite(Files(tmp_path / "out"))
    code.write_text("a = 2\n")
    proof = prove(campaign(tmp_path, ()))
    assert (first.one_code, proof.one_code) == (True, False)
    assert "The diagnosing code changed" in (tmp_path / "out" / "proof.html").read_text()


def test_another_wish_on_a_campaign_that_is_there_is_refused(tmp_path):
    from sim1.proof.start import Wish, open_campaign

    work = campaign(tmp_path, (DRAG,))
    for wish, said in (
        (Wish(cases=3), "leave out --cases"),
        (Wish(seed=3, strength="weak"), "leave out --seed, --strength"),
    ):
        with pytest.raises(BadInput, match=said):
            open_campaign(work.files, wish, work.drawn.laboratory, tmp_path, "c0de")
    empty = Files(tmp_path / "empty")
    with pytest.raises(BadInput, match="say how many cases"):
        open_campaign(empty, Wish(), work.drawn.laboratory, tmp_path, "c0de")
    drawn = open_campaign(empty, Wish(cases=12, seed=4), work.drawn.laboratory, tmp_path, "c0de")
    assert len(drawn.cases) == 12
    assert drawn.seed == "4"
    with pytest.raises(BadInput, match="gave no list of effects"):
        open_campaign(Files(tmp_path / "no"), Wish(cases=2), (sys.executable, "-c", "print(1)"), tmp_path, "c0de")


def _until(true, seconds=30.0):
    ends = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < ends
        time.sleep(0.05)


def test_the_oracle_is_asked_once_of_what_has_effects_of_the_table_and_was_diagnosed(tmp_path, monkeypatch):
    made = campaign(tmp_path, (DRAG, NULL, STRANGE, SHRUNK, PAIR))
    prove(made)
    asked, said = [], []

    def told(bundle, effects, fabric, held):
        assert held == "b"  # as the diagnosis had it
        asked.append((bundle.name, sorted(effects), fabric))
        if "air_drag" not in effects:
            raise NotConverged("the pair snaps")
        return 0.0005, "the model"

    def foretold(bundle, model):
        assert (bundle, model) == (made.files.unseen("case_001"), "the model")
        at_origin_m = 0.0004
        rows = [("u", frame / 60, marker, *[at_origin_m] * 3) for frame in range(4) for marker in range(2)]
        return pd.DataFrame(rows, columns=["recording", "time_s", "marker", "x_m", "y_m", "z_m"])

    monkeypatch.setattr("sim1.proof.oracle.read_bundle", lambda path: path)
    monkeypatch.setattr("sim1.proof.oracle.heldout_m", told)
    monkeypatch.setattr("sim1.mismatch.predict.predict", foretold)
    for _ in range(2):
        ask_oracle(films(made, said.append), rewrite(made.files).outcomes)
    assert asked == [("case_001", ["air_drag"], {"poisson": 0.3}), ("case_005", ["adhesion", "wind"], {"poisson": 0.3})]
    scored = {one.case: one for one in rewrite(made.files).outcomes}
    assert scored["case_001"].oracle_mm == pytest.approx(0.5)
    assert scored["case_001"].gap_closed == pytest.approx((2.0 - 1.0) / (2.0 - 0.5))
    assert scored["case_001"].oracle_unseen_mm == pytest.approx(0.4)
    assert scored["case_001"].unseen_gap_closed == pytest.approx((4.0 - 1.0) / (4.0 - 0.4))
    assert (scored["case_005"].oracle_mm, scored["case_005"].oracle_unseen_mm) == (None, None)
    assert scored["case_005"].oracle_lost == {"heldout": "the pair snaps"}
    assert "no simulation of the oracle: the pair snaps" in (tmp_path / "out" / "proof.html").read_text()
    assert "oracle 0.50" in (tmp_path / "out" / "proof.html").read_text()
    assert said[-1] == "case_005: no simulation of the oracle found its way; 2 of 2 asked"
