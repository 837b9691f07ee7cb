"""Cases that were scored on another machine: they count as they were scored there, where that fits what was drawn and committed to."""

import re
import shutil
import signal

import pytest
from proof_stand_ins import campaign, films, lines_of, notes, write_lines

from sim1.cloth.precise.simulate import NotConverged
from sim1.proof.baselines import sindy
from sim1.proof.baselines.ask import ask_baselines
from sim1.proof.draw import Case
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


@pytest.fixture
def elsewhere(tmp_path):
    """A campaign whose answers, films and findings stayed behind, with what the laboratory was asked before it was carried."""
    made = campaign(tmp_path, (DRAG, NULL))
    prove(made)
    for folder in ("bundles", "unseen", "found", "foretold"):
        shutil.rmtree(made.files.root / folder)
    for path in made.files.root.glob("answers/case_*"):
        path.unlink()
    return made


def test_the_oracle_is_asked_of_films_that_are_made_again_and_are_those_that_were_committed_to(elsewhere, monkeypatch):
    asked, said, before = [], [], len(notes(elsewhere.home, "laboratory"))

    def told(bundle, effects, fabric, held):
        asked.append((bundle, sorted(effects), held))
        raise NotConverged("it snaps")

    monkeypatch.setattr("sim1.proof.oracle.read_bundle", lambda path: path)
    monkeypatch.setattr("sim1.proof.oracle.heldout_m", told)
    for _ in range(2):
        ask_oracle(films(elsewhere, said.append), rewrite(elsewhere.files).outcomes)
    assert asked == [(elsewhere.files.root / "again" / "bundles" / "case_001", ["air_drag"], "b")]
    assert len(notes(elsewhere.home, "laboratory")) == before + 1
    assert said == [
        "case_001: filming again, as its films stayed behind",
        "case_001: no simulation of the oracle found its way; 1 of 1 asked",
    ]
    proof = rewrite(elsewhere.files)
    assert proof.carried == ("case_001", "case_002")
    assert proof.outcomes[0].oracle_lost == {"heldout": "it snaps"}
    assert proof.outcomes[1].oracle_s is None


def test_another_film_than_the_one_that_was_committed_to_is_told_and_not_asked(elsewhere, monkeypatch):
    laboratory, said = elsewhere.home / "laboratory.py", []
    laboratory.write_text(laboratory.read_text().replace("np.eye(4)", "np.ones((4, 4))"))
    monkeypatch.setattr("sim1.proof.oracle.heldout_m", lambda *given: pytest.fail("asked of another film"))
    ask_oracle(films(elsewhere, said.append), rewrite(elsewhere.files).outcomes)
    assert re.search(r"case_001: not asked, .*again/answers/case_001.npz: changed since it was committed to", said[-1])
    laboratory.write_text("raise SystemExit('no light')")
    shutil.rmtree(elsewhere.files.again.root)
    ask_oracle(films(elsewhere, said.append), rewrite(elsewhere.files).outcomes)
    assert "case_001: not asked" in said[-1]
    assert "no light" in said[-1]


def test_ctrl_c_ends_the_laboratory_that_films_again(elsewhere, monkeypatch):
    laboratory, asked = elsewhere.home / "laboratory.py", []
    laboratory.write_text("import time; time.sleep(600)")

    def interrupted(process, *args, **kwargs):
        asked.append(process)
        raise KeyboardInterrupt

    monkeypatch.setattr("subprocess.Popen.communicate", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ask_oracle(films(elsewhere, lambda line: None), rewrite(elsewhere.files).outcomes)
    assert [process.returncode for process in asked] == [-signal.SIGKILL]


def test_simpler_methods_are_asked_elsewhere_where_the_calibrated_baseline_came_along(elsewhere, monkeypatch):
    asked, said = [], []
    brought = elsewhere.files.found("case_001") / "baseline.yaml"
    brought.parent.mkdir(parents=True)
    brought.write_text("calibrated")

    def sparse(bundle, physics, held):
        asked.append((bundle, physics))
        return sindy.Named(effects=("wind",), heldout_m=0.0015)

    monkeypatch.setattr("sim1.proof.baselines.ask.read_bundle", lambda path: path)
    monkeypatch.setattr("sim1.proof.baselines.ask.read_physics", lambda path: path.read_text())
    monkeypatch.setattr("sim1.proof.baselines.ask.sparse_effects", sparse)
    monkeypatch.setattr("sim1.proof.baselines.ask.heldout_m", lambda bundle, physics, held: 0.0012)
    ask_baselines(films(elsewhere, said.append), rewrite(elsewhere.files).outcomes)
    assert asked == [(elsewhere.files.again.bundle("case_001"), "calibrated")]
    assert said[0].startswith("case_002: not asked, as ")
    outcome = rewrite(elsewhere.files).outcomes[0]
    assert outcome.baselines.sindy.named == ("wind",)
    assert outcome.baselines.residual.heldout_mm == pytest.approx(1.2)


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


def test_a_verdict_that_came_along_is_held_against_what_was_sealed_and_what_was_scored(work):
    for path in work.files.root.glob("answers/case_*"):
        path.unlink()
    shutil.rmtree(work.files.found("case_002"))
    proof = rewrite(work.files)
    assert (proof.carried, proof.carried_unsealed) == (("case_001", "case_002"), ("case_002",))
    assert "says what was found, of case_002." in (work.files.root / "proof.html").read_text()
    outcome = work.files.outcome("case_001")
    outcome.write_text(
        outcome.read_text().replace('"air_drag"\n ]', '"wind"\n ]').replace('"right": true', '"right": false')
    )
    assert re.search(r"says named wind; .*verdict.json says named air_drag", rewrite(work.files).not_scored[0].why)
    verdict = work.files.found("case_001") / "verdict.json"
    verdict.write_text(verdict.read_text().replace("air_drag", "wind"))
    assert re.search(r"verdict.json: changed since it was sealed", rewrite(work.files).not_scored[0].why)


CARRIED = {
    "called right": (lambda folder: swapped(folder / "outcomes/case_001.json", '"right":true', '"right":false'), "does not follow"),
    "of another seed": (lambda folder: swapped(folder / "outcomes/case_001.json", '"seed":1', '"seed":8'), "drawn was"),
    "of another kind": (lambda folder: swapped(folder / "outcomes/case_001.json", '"kind":"single"', '"kind":"outside"'), "it is single"),
    "never committed to": (lambda folder: never_committed(folder), "nobody committed"),
}  # fmt: skip


def never_committed(folder):
    """As earlier code left it, whose lines hold no hash of the one before."""
    write_lines(folder, [line for line in lines_of(folder) if line.get("of") != "case_001"])


def swapped(path, old, new):
    """Whatever spaces stand around the colon."""
    text, count = re.subn(re.escape(old).replace(":", r":\s*"), new, path.read_text())
    assert count, f"{path} has no {old}: {text}"
    path.write_text(text)


@pytest.mark.parametrize("wrong", CARRIED)
def test_a_stored_outcome_that_does_not_fit_what_was_drawn_and_committed_to_counts_nowhere(tmp_path, work, wrong):
    do, word = CARRIED[wrong]
    for path in (tmp_path / "out" / "answers").glob("case_*"):
        path.unlink()
    assert prove(campaign(tmp_path, ())).carried == ("case_001", "case_002")
    do(tmp_path / "out")
    proof = prove(campaign(tmp_path, ()))
    assert proof.carried == ("case_002",)
    [left] = proof.not_scored
    assert left.case == "case_001"
    assert word in left.why
