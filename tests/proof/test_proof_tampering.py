"""Answers and films that are planted, changed, exchanged or gone: what a campaign finds of it."""

import re
import shutil

import pytest
from proof_stand_ins import DRAG, NULL, campaign, lines_of, notes, write_lines

from pipeline.home import REPOSITORY
from sim1.proof.files import Files
from sim1.proof.found_seal import begin
from sim1.proof.prove import prove
from sim1.proof.report import rewrite
from sim1.stage import BadInput


def test_wrong_answers_planted_beside_the_bundle_change_nothing(tmp_path):
    for folder, plant in ((tmp_path / "plain", False), (tmp_path / "planted", True)):
        folder.mkdir()
        work = campaign(folder, (DRAG,))
        list(prove(work, only_films=True).outcomes)
        if plant:
            wrong = (work.files.answers("case_001")).read_text().replace("air_drag", "wind")
            for name in ("answers.json", "case_001.json"):
                (work.files.root / "bundles" / name).write_text(wrong)
        prove(campaign(folder, (DRAG,)))
    plain, planted = (rewrite(Files(tmp_path / name / "out")).outcomes[0] for name in ("plain", "planted"))
    assert planted.model_dump(exclude={"seconds"}) == plain.model_dump(exclude={"seconds"})
    assert (planted.named, planted.right) == (("air_drag",), True)


def _swap_film(bundle):
    (bundle / "bundle.yaml").write_text("looks: wind")


FILMS = {
    "not given": (
        lambda bundle: _swap_film(bundle.parents[1] / "unseen" / "case_001"),
        r"unseen/case_001/bundle.yaml: changed since it was committed to",
    ),
    "changed": (_swap_film, r"bundles/case_001/bundle.yaml: changed since it was committed to"),
    "added": (
        lambda bundle: (bundle / "more.yaml").write_text("{}"),
        r"bundles/case_001/more.yaml: came after the others were committed to",
    ),
    "gone": (lambda bundle: (bundle / "bundle.yaml").unlink(), r"bundles/case_001/bundle.yaml: committed to at"),
}


@pytest.mark.parametrize("harm", FILMS)
def test_films_that_changed_after_the_diagnosis_are_found_and_the_case_is_not_scored(work, harm):
    do, said = FILMS[harm]
    assert rewrite(work.files).films_unsealed == ()
    do(work.files.bundle("case_001"))
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert re.search(said, proof.not_scored[0].why)


def _on_another_machine(work, folder):
    """The films and answers of the first case stayed behind, and what makes them again rounds otherwise."""
    for behind in (work.files.bundle("case_001"), work.files.unseen("case_001")):
        shutil.rmtree(behind)
    work.files.answers("case_001").unlink()
    (folder / "rounds").touch()


def test_films_that_another_machine_makes_otherwise_before_a_diagnosis_has_ended_are_committed_to_anew(tmp_path):
    work = campaign(tmp_path, (DRAG, NULL))
    list(prove(work, only_films=True).outcomes)
    first = (work.files.root / "commitments.jsonl").read_bytes()
    begin(work.files, "case_001", "c0de")
    _on_another_machine(work, tmp_path)
    proof = prove(work)
    assert [(one.case, one.right) for one in proof.outcomes] == [("case_001", True), ("case_002", True)]
    assert (proof.films_again, proof.diagnosed.begun_twice) == (("case_001",), ("case_001",))
    assert [one.of for one in proof.commitments] == ["list", "case_001", "case_002", "case_001"]
    assert (work.files.root / "commitments.jsonl").read_bytes().startswith(first)
    assert (proof.totals.named.count, proof.totals_as_first_filmed.named.of) == (1, 0)
    page = (work.files.root / "proof.html").read_text()
    assert "were committed to anew before a diagnosis ended, in case_001:" in page
    assert "Without these cases: single effects" in page
    films = work.files.unseen("case_001") / "recordings" / "u" / "markers.parquet"
    films.write_bytes(b"of the first half second")  # as they were at first: the latest line counts
    assert "changed since it was committed to" in rewrite(work.files).not_scored[0].why


def test_films_of_another_laboratory_are_not_committed_to_anew(tmp_path):
    work = campaign(tmp_path, (DRAG, NULL))
    list(prove(work, only_films=True).outcomes)
    _on_another_machine(work, tmp_path)
    program = tmp_path / "laboratory.py"
    program.write_text(program.read_text() + "# brighter\n")
    proof = prove(work)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert re.search(
        r"changed since .* filmed again by another laboratory .* or remove .*case_001", proof.not_scored[0].why
    )
    (tmp_path / "rounds").unlink()
    shutil.rmtree(work.files.bundle("case_001"))  # filmed once more, it is the film that was committed to
    assert [one.right for one in prove(work).outcomes] == [True, True]


def test_films_of_a_diagnosis_that_ended_are_not_committed_to_anew(tmp_path):
    work = campaign(tmp_path, (DRAG, NULL))
    assert prove(work).films_again == ()
    for lost in (work.files.record("case_001"), work.files.outcome("case_001")):
        lost.unlink()
    _on_another_machine(work, tmp_path)
    proof = prove(work)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert re.search(r"markers.parquet: changed since it was committed to", proof.not_scored[0].why)
    assert len(proof.commitments) == 3
    assert len(notes(tmp_path, "diagnosis")) == 2


def test_cases_that_earlier_code_committed_to_by_their_answers_alone_are_read_and_said_to_be(work):
    lines = lines_of(work.files.root)
    for line in lines:
        if line.get("of") == "case_001":
            line["sha256"] = {name: one for name, one in line["sha256"].items() if name.startswith("answers/")}
    write_lines(work.files.root, lines)
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_001", "case_002"]
    assert proof.films_unsealed == ("case_001",)
    assert "<strong>not the films</strong> of case_001" in (work.files.root / "proof.html").read_text()


@pytest.mark.parametrize("name", ["blind", "by_kind"])
def test_campaigns_that_are_stored_are_added_up_and_told_to_be_without_films(tmp_path, name):
    shutil.copytree(REPOSITORY / "docs" / "campaign" / name, tmp_path / name)
    proof = rewrite(Files(tmp_path / name))
    assert len(proof.outcomes) == 60
    assert proof.films_unsealed == tuple(one.case for one in proof.outcomes)
    assert proof.diagnosed.unsealed == tuple(one.case for one in proof.outcomes)
    page = (tmp_path / name / "proof.html").read_text()
    assert "Not told of case_001, case_002" in page
    assert "<strong>What was found is not sealed</strong> in case_001, case_002" in page


def test_a_stored_campaign_of_medium_strength_keeps_its_headline_and_is_told_to_have_set_thresholds(tmp_path):
    shutil.copytree(REPOSITORY / "docs" / "campaign" / "along", tmp_path / "along")
    proof = rewrite(Files(tmp_path / "along"))
    totals = proof.totals
    asked = (totals.named, totals.nulls_called_none, totals.outside_without_name, totals.several_named)
    assert [(share.count, share.of) for share in asked] == [(19, 24), (20, 20), (6, 8), (7, 8)]
    assert (totals.first_ranked.count, totals.effects_ever_named.count, totals.effects_ever_named.of) == (23, 17, 21)
    assert totals.by_strength["medium"].named == totals.named
    assert (totals.unseen_cases, totals.gaps, totals.unseen_gaps) == (32, 26, 28)
    assert [one.case for one in proof.outcomes if one.kind == "null"] == list(proof.of_thresholds)
    page = (tmp_path / "along" / "proof.html").read_text()
    assert f"were chosen by</strong> {', '.join(proof.of_thresholds)}," in page
    assert "<td>medium</td><td>19 of 24 (95 % interval 58 to 93 %)</td>" in page


def test_answers_changed_after_the_diagnosis_are_found_and_the_case_is_not_scored(work):
    path = work.files.answers("case_001")
    path.write_text(path.read_text().replace("2.0", "1.9"))
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert proof.not_scored[0].case == "case_001"
    assert "case_001.json: changed since it was committed to" in proof.not_scored[0].why
    drawn = work.files.drawn
    drawn.write_text(drawn.read_text().replace("air_drag", "adhesion"))
    with pytest.raises(BadInput, match=r"drawn\.json: changed since"):
        rewrite(work.files)


def test_answers_exchanged_before_the_diagnosis_stop_it(tmp_path):
    prove(campaign(tmp_path, (DRAG, NULL)), only_films=True)
    assert notes(tmp_path, "diagnosis") == []
    path = tmp_path / "out" / "answers" / "case_001.json"
    path.write_text(path.read_text().replace("air_drag", "wind"))
    proof = prove(campaign(tmp_path, (DRAG, NULL)))
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert "case_001.json: changed since" in proof.not_scored[0].why
    assert len(notes(tmp_path, "diagnosis")) == 1


def test_a_case_whose_answers_changed_after_it_was_scored_counts_nowhere_even_when_they_are_gone(work):
    path = work.files.answers("case_001")
    path.write_text(path.read_text().replace("air_drag", "wind"))
    assert [one.case for one in rewrite(work.files).outcomes] == ["case_002"]
    path.unlink()
    proof = rewrite(work.files)
    assert [one.case for one in proof.outcomes] == ["case_002"]
    assert proof.carried == ()
