"""Cases that were begun, filmed or diagnosed more than once: what of the first time counts, what is told, and what does not stay."""

from dataclasses import replace

from proof_stand_ins import DRAG, campaign

from sim1.proof.found_seal import begin
from sim1.proof.prove import prove


def test_code_by_which_a_diagnosis_began_and_did_not_end_counts_too(tmp_path):
    work = campaign(tmp_path, (DRAG,))
    begin(work.files, "case_001", "f" * 64)
    assert not prove(work).one_code


def test_a_case_that_could_not_be_filmed_is_told_when_it_was_diagnosed_after_all(tmp_path):
    work, laboratory = campaign(tmp_path, (DRAG,)), tmp_path / "laboratory.py"
    whole = laboratory.read_text()
    laboratory.write_text("raise SystemExit('no light')")
    prove(work)
    laboratory.write_text(whole)
    said = []
    prove(replace(work, tell=said.append))
    assert any(line.startswith("case_001: named air_drag") for line in said)


def test_what_was_said_beside_another_diagnosis_of_a_case_does_not_stay(tmp_path):
    work = campaign(tmp_path, (DRAG,))
    prove(work)
    for file in (work.files.oracle("case_001"), work.files.baselines("case_001")):
        file.parent.mkdir(exist_ok=True)
        file.write_text("of the recording that was held out then")
    work.files.record("case_001").unlink()
    work.files.outcome("case_001").unlink()
    assert prove(work).outcomes[0].oracle_s is None
    assert not work.files.oracle("case_001").exists()
