import json
from pathlib import Path

import pandas as pd
import pytest
import yaml

from sim1.policy import paper
from sim1.policy.cost import PER_TRAJECTORY_STAGES, paper_simulation, read_prices, read_timings, real_collection
from sim1.policy.stage import CostReportConfig, check_cost_report, cost_report
from sim1.stage import BadInput

PRICES = Path(__file__).parents[2] / "data" / "prices.yaml"


@pytest.fixture
def inputs(tmp_path):
    folders = {}
    for garment, accepted in (("towel", [True, True, False]), ("tshirt", [True, True, True])):
        folders[garment] = tmp_path / garment
        folders[garment].mkdir()
        table = pd.DataFrame({"accepted": accepted, "success": True, "perturbed": False, "reason": ""})
        table.to_parquet(folders[garment] / "decisions.parquet")
    return {"valid_trajectories": folders, "prices": {"": PRICES}, "dataset": {"": shown(tmp_path / "dataset", 2, 3)}}


def shown(folder, towels, shirts):
    """The provenance of a dataset of so many trajectories, each in two appearances."""
    folder.mkdir(exist_ok=True)
    names = [("towel", f"{at:04d}") for at in range(towels)] + [("tshirt", f"{at:04d}") for at in range(shirts)]
    rows = [{"garment": garment, "trajectory": name, "appearance": at} for garment, name in names for at in (0, 1)]
    pd.DataFrame(rows, columns=["garment", "trajectory", "appearance"]).to_parquet(folder / "provenance.parquet")
    return folder


def test_stages_that_took_no_time_are_no_pace(inputs, tmp_path):
    path = tmp_path / "timings.json"
    path.write_text(json.dumps({stage: {"towel": 0.0} for stage in PER_TRAJECTORY_STAGES}))
    cost_report({**inputs, "timings": {"": path}}, tmp_path, CostReportConfig())
    assert len(json.loads((tmp_path / "costs.json").read_text())["methods"]) == 2  # this machine is not among them


@pytest.fixture
def timings(tmp_path):
    path = tmp_path / "timings.json"
    content = {
        "scan": {"towel": 1.0, "tshirt": 1.0},
        "candidate_trajectories": {"towel": 60.0, "tshirt": 100.0},
        "valid_trajectories": {"towel": 5.0, "tshirt": 5.0},
        "rendered_episodes": {"towel": 100.0, "tshirt": 120.0},
        "dataset": {"": 10.0},
    }
    path.write_text(json.dumps(content))
    return path


def test_the_papers_figures_follow_from_its_prices():
    prices = read_prices(PRICES)
    real, server = real_collection(prices), paper_simulation(prices)
    assert real.usd_per_day == pytest.approx(paper.COST_PER_DAY["real"], abs=0.5)
    assert server.usd_per_day == pytest.approx(paper.COST_PER_DAY["simulation"], abs=0.5)
    for method, (a_day, unit, relative) in zip((real, server), paper.COSTS.values(), strict=True):
        assert method.trajectories_per_day == pytest.approx(a_day, abs=2)
        assert method.usd_per_trajectory == pytest.approx(unit, abs=0.005)
        assert method.usd_per_trajectory / real.usd_per_trajectory == pytest.approx(relative, abs=0.0005)
    assert real.usd_per_trajectory / server.usd_per_trajectory == pytest.approx(27, abs=0.5)
    assert server.trajectories_per_day / real.trajectories_per_day == pytest.approx(6.8, abs=0.05)


def test_measured_seconds_become_trajectories_a_day(tmp_path, inputs, timings):
    facts = cost_report({**inputs, "timings": {"": timings}}, tmp_path, CostReportConfig())
    assert [finding.name for finding in check_cost_report(tmp_path) if not finding.passed] == []
    assert facts["accepted_count"] == 5
    here = json.loads((tmp_path / "costs.json").read_text())["methods"][2]
    assert here["measured"]
    assert here["trajectories_per_day"] == pytest.approx(
        86400 / (400 / 5)
    )  # 400 s of the repeated stages, scan left out
    price = yaml.safe_load(PRICES.read_text())["this_machine"]["usd_per_hour"]
    assert here["usd_per_trajectory"] == pytest.approx(80 / 3600 * price)
    assert "5 accepted trajectories" in (tmp_path / "report.html").read_text()


def test_seconds_of_an_attempt_of_an_accepted_trajectory_and_of_its_frames_are_told_with_counts(
    tmp_path, inputs, timings
):
    cost_report({**inputs, "timings": {"": timings}}, tmp_path, CostReportConfig())
    costs = json.loads((tmp_path / "costs.json").read_text())
    assert (costs["attempted_count"], costs["accepted_count"]) == (6, 5)
    assert costs["pace"] == pytest.approx(
        {"attempted_s": 170 / 6, "accepted_s": 170 / 5, "shown_s": 230 / 5, "frames_share": 220 / 400}
    )
    page = (tmp_path / "report.html").read_text()
    for words in ("of 6", ">28.33<", ">34<", ">46<", ">80<", "Frames take 55 %"):
        assert words in page


def test_stages_whose_seconds_were_not_there_yet_are_named(tmp_path, inputs, timings):
    content = json.loads(timings.read_text())
    timings.write_text(json.dumps({**content, "scaling_report": {}, "image_trials": {}}))
    cost_report({**inputs, "timings": {"": timings}}, tmp_path, CostReportConfig())
    assert json.loads((tmp_path / "costs.json").read_text())["not_in_seconds"] == ["scaling_report", "image_trials"]
    page = (tmp_path / "report.html").read_text()
    assert (
        "Not in this table, as nothing of them had been made when this page was: scaling_report, image_trials." in page
    )


def test_seconds_of_rendering_are_of_those_that_were_rendered(tmp_path, inputs, timings):
    """Of five accepted trajectories one of each garment, as `max_episodes: 1` has it."""
    shown(tmp_path / "dataset", 1, 1)
    facts = cost_report({**inputs, "timings": {"": timings}}, tmp_path, CostReportConfig())
    assert [finding.name for finding in check_cost_report(tmp_path) if not finding.passed] == []
    assert (facts["accepted_count"], facts["shown_count"]) == (5, 2)
    here = json.loads((tmp_path / "costs.json").read_text())["methods"][2]
    assert here["trajectories_per_day"] == pytest.approx(86400 / (170 / 5 + 230 / 2))
    assert "5 accepted trajectories, 2 of them rendered and in the dataset" in (tmp_path / "report.html").read_text()


def test_without_a_readable_provenance_it_is_told(tmp_path, inputs):
    (tmp_path / "dataset" / "provenance.parquet").write_bytes(b"no table")
    with pytest.raises(BadInput, match=r"provenance\.parquet: not a readable table"):
        cost_report(inputs, tmp_path, CostReportConfig())


def test_without_timings_this_machine_is_not_measured(tmp_path, inputs):
    facts = cost_report(inputs, tmp_path, CostReportConfig())
    assert [finding.name for finding in check_cost_report(tmp_path) if not finding.passed] == []
    assert len(facts["methods"]) == 2
    assert "not measured" in (tmp_path / "report.html").read_text()


def test_a_stage_without_its_seconds_leaves_this_machine_unmeasured(tmp_path, inputs, timings):
    content = json.loads(timings.read_text())
    del content["rendered_episodes"]
    timings.write_text(json.dumps(content))
    facts = cost_report({**inputs, "timings": {"": timings}}, tmp_path, CostReportConfig())
    assert len(facts["methods"]) == 2


def test_an_artifact_that_took_nobody_knows_how_long_leaves_this_machine_unmeasured(tmp_path, inputs, timings):
    content = json.loads(timings.read_text())
    content["rendered_episodes"]["towel"] = None
    timings.write_text(json.dumps(content))
    facts = cost_report({**inputs, "timings": {"": timings}}, tmp_path, CostReportConfig())
    assert len(facts["methods"]) == 2
    assert "not known" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": "sim1.prices/2"}, "expected 'sim1.prices/1'"),
        ({"this_machine": {"description": "x", "usd_per_hour": -1.0}}, "this_machine.usd_per_hour is -1.0"),
        ({"this_machine": {"description": "x", "usd_per_hour": "cheap"}}, "usd_per_hour"),
        ({"coffee": 3}, "coffee"),
    ],
)
def test_a_wrong_price_file_is_named(tmp_path, change, message):
    path = tmp_path / "prices.yaml"
    path.write_text(yaml.safe_dump({**yaml.safe_load(PRICES.read_text()), **change}))
    with pytest.raises(BadInput, match=message) as error:
        read_prices(path)
    assert str(path) in str(error.value)


@pytest.mark.parametrize("text", ["[]", "{", '{"scan": {"towel": "long"}}', '{"scan": {"towel": -1}}', '{"scan": 3}'])
def test_wrong_timings_are_named(tmp_path, text):
    path = tmp_path / "timings.json"
    path.write_text(text)
    with pytest.raises(BadInput, match=r"timings\.json"):
        read_timings(path)


def test_check_sees_a_unit_cost_that_is_not_the_pages(tmp_path, inputs):
    cost_report(inputs, tmp_path, CostReportConfig())
    costs = json.loads((tmp_path / "costs.json").read_text())
    costs["methods"][0]["usd_per_trajectory"] *= 2
    (tmp_path / "costs.json").write_text(json.dumps(costs))
    assert [f.name for f in check_cost_report(tmp_path) if not f.passed] == ["page_states_its_counts"]


@pytest.mark.parametrize("change", [{"accepted_count": 7}, {"shown_count": 3}, {"seconds": {}}])
def test_check_sees_a_pace_of_this_machine_that_is_not_that_of_its_seconds(tmp_path, inputs, timings, change):
    cost_report({**inputs, "timings": {"": timings}}, tmp_path, CostReportConfig())
    assert [f.name for f in check_cost_report(tmp_path) if not f.passed] == []
    costs = json.loads((tmp_path / "costs.json").read_text())
    (tmp_path / "costs.json").write_text(json.dumps({**costs, **change}))
    assert [f.name for f in check_cost_report(tmp_path) if not f.passed] == ["pace_follows_from_seconds"]


def test_check_sees_a_machine_that_was_measured_and_is_missing(tmp_path, inputs, timings):
    cost_report(inputs, tmp_path, CostReportConfig())
    costs = json.loads((tmp_path / "costs.json").read_text())
    (tmp_path / "costs.json").write_text(json.dumps({**costs, "seconds": json.loads(timings.read_text())}))
    assert [f.name for f in check_cost_report(tmp_path) if not f.passed] == ["pace_follows_from_seconds"]


def test_check_sees_a_cost_that_is_no_number(tmp_path, inputs):
    cost_report(inputs, tmp_path, CostReportConfig())
    costs = json.loads((tmp_path / "costs.json").read_text())
    costs["methods"][1]["usd_per_day"] = float("nan")
    (tmp_path / "costs.json").write_text(json.dumps(costs))
    assert [f.name for f in check_cost_report(tmp_path) if not f.passed] == ["costs_are_numbers"]
