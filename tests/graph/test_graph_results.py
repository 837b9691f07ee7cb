"""What a run says at its end about results that it did not make."""

import re

import pytest

from assets_defs import _results
from assets_defs._recipe import Snapshot
from assets_defs._results import results, warnings
from assets_defs._run import run_with_progress
from assets_defs._summary import write_summary
from pipeline import load_graph


@pytest.fixture
def said(made, monkeypatch):
    """Function that gives the lines on results, as after a run that made the artifacts with these labels."""
    monkeypatch.setattr(_results, "RESULTS", {"dataset": ("dataset", "content.txt"), "report": ("report", "gone.html")})

    def lines(*labels: str, profile: str = "quick") -> list[str]:
        with made.instance() as instance:
            return list(results(Snapshot(instance, load_graph(made.home, profile), made.home), labels))

    return lines


def test_a_result_of_this_run_stands_without_remark_and_an_older_one_with_age_and_state(made, said):
    assert said("dataset") == ["dataset: data/store/dataset/_/content.txt"]
    assert re.fullmatch(r"dataset: data/store/dataset/_/content\.txt \(made \d+ (s|min) ago, fresh\)", said()[0])


def test_a_result_that_no_longer_holds_names_what_changed(made, said):
    made.add_garment("towel", "point 1 2 3")
    assert said()[0].endswith("stale: scan/towel: source scans changed)")
    made.add_garment("towel", "bad")
    made.run()
    assert said()[0].endswith("stale: scan/towel: the last try failed)")


def test_a_result_of_another_profile_says_so(made, said):
    (made.root / "pipeline" / "profiles" / "smoke.yaml").write_text("mesh: {width: 1}\n")
    assert said(profile="smoke")[0].endswith(
        "stale: mesh/shirt: setting width changed from None to 1; made in profile quick)"
    )


def test_warnings_of_checks_are_listed_with_their_artifact(made):
    made.stages(mesh={"config": {"odd": True}})
    made.run()
    with made.instance() as instance:
        found = list(warnings(Snapshot(instance, made.graph, made.home)))
        page = write_summary(Snapshot(instance, made.graph, made.home)).read_text()
    assert [(node.id, garment) for node, garment, _ in found] == [("mesh", "shirt"), ("mesh", "towel")]
    assert {said for _, _, said in found} == {"is even: an odd artifact; look at it"}
    assert "Warning, towel: is even: an odd artifact; look at it." in page


def test_the_end_of_a_run_has_warnings_of_what_it_made_and_counts_the_others(made, capsys):
    made.stages(mesh={"config": {"odd": True}})
    made.run(garments=["shirt"])
    assert run_with_progress(made.home, made.graph, set(made.graph.nodes), ["towel"], jobs=0) == 0
    answer = capsys.readouterr().out
    assert "warning mesh/towel: is even: an odd artifact; look at it" in answer
    assert "warning mesh/shirt" not in answer
    assert "warnings on artifacts of earlier runs: 1," in answer


def test_the_page_names_the_profile_of_each_artifact_when_they_are_mixed(made):
    def page(profile: str) -> str:
        with made.instance() as instance:
            return write_summary(Snapshot(instance, load_graph(made.home, profile), made.home)).read_text()

    (made.root / "pipeline" / "profiles" / "smoke.yaml").write_text("mesh: {width: 1}\n")
    assert "Profile quick. Garments: shirt, towel." in page("quick")
    made.run(nodes={"scan", "mesh"}, garments=["towel"], profile="smoke")
    mixed = page("quick")
    assert "Mixed: 4 of 8 artifacts are what profile quick makes now" in mixed
    assert (
        "<td>towel</td><td>smoke</td><td>stale: setting width changed from 1 to None; made in profile smoke</td>"
        in mixed
    )
    assert "<td>shirt</td><td>quick</td><td>fresh</td>" in mixed


def test_what_waits_for_garments_that_were_not_asked_for_is_no_failure(project, capsys):
    assert run_with_progress(project.home, project.graph, set(project.graph.nodes), ["towel"], jobs=0) == 0
    answer = capsys.readouterr().out
    assert "3 made, 0 fresh already, 0 failed, 2 waiting" in answer
    assert "waiting dataset: model/shirt is missing" in answer
