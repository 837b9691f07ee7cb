"""Automation follows the graph's files as they are, not as they were when the UI was opened."""

import pytest
from test_graph_automation import requested

from assets_defs.definitions import definitions


@pytest.fixture
def location(made):
    """The code location as a UI that stays open has it, everything made."""
    return definitions(made.graph, made.home)


def test_a_changed_setting_is_asked_for_until_it_is_made_and_no_longer(location, made):
    (made.root / "pipeline" / "profiles" / "quick.yaml").write_text("model: {width: 3}\n")
    with made.instance() as instance:
        assert requested(location, instance)[0] == ["model/shirt", "model/towel"]
    made.run(nodes={"model"})
    with made.instance() as instance:
        assert requested(location, instance)[0] == ["dataset"]
    made.run()
    with made.instance() as instance:
        assert requested(location, instance)[0] == []


def test_a_full_run_in_another_profile_leaves_nothing_to_ask_for(location, made, monkeypatch):
    monkeypatch.delenv("SIM1_PROFILE")
    (made.root / "pipeline" / "profiles" / "smoke.yaml").write_text("mesh: {width: 1}\n")
    assert made.command("run", "--profile", "smoke", "--jobs", "0").returncode == 0
    with made.instance() as instance:
        assert requested(location, instance)[0] == []


def test_a_stage_that_is_no_more_is_not_asked_for(location, made):
    rows = (made.root / "pipeline" / "stages.yaml").read_text().split("- compares:")
    assert len(rows) == 2
    (made.root / "pipeline" / "stages.yaml").write_text(rows[0])
    assert "report" not in made.graph.nodes
    (made.home.store / "report" / "_" / "content.txt").unlink()
    with made.instance() as instance:
        assert requested(location, instance)[0] == []


def test_the_schedule_says_whose_two_o_clock_it_means(location):
    schedule = location.resolve_schedule_def("nightly")
    assert schedule.execution_timezone in (None, "UTC")
    assert "02:00 UTC" in schedule.description
