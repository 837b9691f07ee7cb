import json

import pandas as pd
import pytest

from sim1.policy.ablation_page import result_sections
from sim1.policy.stage import AblationReportConfig, ablation_report, check_ablation_report
from sim1.policy.worlds import REALITY, SIMULATOR
from sim1.stage import BadInput


def decisions(folder, accepted, rejected):
    """Candidates, one of the accepted ones not folded, and three that were disturbed on purpose."""
    folder.mkdir(parents=True)
    count = accepted + rejected
    table = pd.DataFrame(
        {
            "accepted": [True] * accepted + [False] * rejected + [True, False, False],
            "success": [True] * (accepted - 1) + [False] * (rejected + 1) + [True, False, False],
            "perturbed": [False] * count + [True] * 3,
            "reason": "",
        }
    )
    table.to_parquet(folder / "decisions.parquet")
    return folder


def trials(folder, successes, failures, size=8, seeds=1, world=REALITY):
    """So many successes at the largest size, dealt to networks in turn; at a smaller one everything fails."""
    folder.mkdir(parents=True)
    flags = [True] * successes + [False] * failures
    numbers = range(len(flags))
    table = pd.DataFrame(
        {
            "world": world,
            "trained_on": "generated",
            "size": size,
            "seed": [number % seeds for number in numbers],
            "garment": "towel",
            "shift": "spatial",
            "trial": [number // seeds for number in numbers],
            "success": flags,
        }
    )
    small = table.assign(size=2, success=False)
    real = table.assign(trained_on="real", size=16, success=True)
    pd.concat([small, table, real], ignore_index=True).to_parquet(folder / "evaluation.parquet")
    return folder


@pytest.fixture
def inputs(tmp_path):
    return {
        "valid_trajectories": {
            "towel": decisions(tmp_path / "b1", 4, 6),
            "tshirt": decisions(tmp_path / "b2", 2, 8),
        },
        "policy": {"": trials(tmp_path / "bp", 3, 7)},
        "minimum_jerk/valid_trajectories": {
            "towel": decisions(tmp_path / "m1", 1, 9),
            "tshirt": decisions(tmp_path / "m2", 1, 9),
        },
        "minimum_jerk/policy": {"": trials(tmp_path / "mp", 0, 10)},
        "other_network/policy": {"": trials(tmp_path / "op", 5, 5)},
    }


def rows(out):
    return {row["variant"]: row for row in json.loads((out / "table.json").read_text())["rows"]}


def test_rates_are_counted_over_all_garments_at_the_largest_size(tmp_path, inputs):
    ablation_report(inputs, tmp_path, AblationReportConfig())
    assert [finding.name for finding in check_ablation_report(tmp_path) if not finding.passed] == []
    base = rows(tmp_path)["base"]
    assert (base["accepted_count"], base["candidate_count"]) == (6, 20)
    assert (base["success_count"], base["trial_count"]) == (3, 10)
    assert base["accepted_and_successful_count"] == 4
    assert base["all_trials"]["interval"] == pytest.approx([0.1078, 0.6032], abs=1e-4)


def test_where_a_variant_changes_nothing_the_base_counts_are_its_counts(tmp_path, inputs):
    ablation_report(inputs, tmp_path, AblationReportConfig())
    table = rows(tmp_path)
    assert list(table) == ["base", "minimum_jerk", "other_network"]
    assert table["other_network"]["candidate_count"] == 20
    assert table["other_network"]["own_stages"] == ["policy"]
    assert table["minimum_jerk"]["accepted_count"] == 2


def test_other_trajectories_never_stand_beside_the_policy_of_the_base(tmp_path, inputs):
    """A variant that ends before its policy was not tried."""
    del inputs["minimum_jerk/policy"]
    ablation_report(inputs, tmp_path, AblationReportConfig())
    row = rows(tmp_path)["minimum_jerk"]
    assert (row["trial_count"], row["success_rate"], row["own_stages"]) == (0, None, ["valid_trajectories"])
    assert "not run" in (tmp_path / "report.html").read_text()


def test_what_was_never_made_is_named(tmp_path, inputs):
    del inputs["policy"]
    with pytest.raises(BadInput, match="'base': no artifact of policy"):
        ablation_report(inputs, tmp_path, AblationReportConfig())


def test_page_states_counts_and_the_papers_table(tmp_path, inputs):
    ablation_report(inputs, tmp_path, AblationReportConfig())
    page = (tmp_path / "report.html").read_text()
    for words in ("6 of 20", "2 of 20", "0 of 10", "minimum_jerk", "scripted expert", "deformation-stable solver"):
        assert words in page


def table_of(out):
    """Rows of the page's table by variant, without the spaces that keep words together."""
    [section] = result_sections(out)
    rows = [{key: str(cell).replace("\N{NO-BREAK SPACE}", " ") for key, cell in row.items()} for row in section.table]
    return {row["Method | here"]: row for row in rows}, " ".join(section.paragraphs)


def test_the_table_has_how_many_trajectories_taught_and_the_difference_to_the_base_over_pairs(tmp_path, inputs):
    """Three and five of ten trials from the same placements: the first three succeed in both."""
    inputs["other_network/policy"] = {"": trials(tmp_path / "other", 5, 5, size=7)}
    ablation_report(inputs, tmp_path, AblationReportConfig())
    assert [finding.name for finding in check_ablation_report(tmp_path) if not finding.passed] == []
    shown, said = table_of(tmp_path)
    assert {name: row["Trajectories"] for name, row in shown.items() if row["Trajectories"] != "None"} == {
        "base (all parts)": "8",
        "minimum_jerk": "8",
        "other_network": "7",
    }
    difference = {name: row["Average minus base (points)"] for name, row in shown.items()}
    assert difference["other_network"] == "+20 (-10 to +45), 10 pairs"
    assert difference["minimum_jerk"] == "-30 (-60 to +4), 10 pairs"
    assert difference["base (all parts)"] == "None"
    assert difference["slicing"] == "not run"
    assert "One network alone drove everywhere here" in said


def test_variants_that_drive_in_simulators_of_their_own_are_no_pairs(tmp_path, inputs):
    """Where there is no stand-in reality each is tried in the simulator that made its own data."""
    inputs["policy"] = {"": trials(tmp_path / "own", 3, 7, world=SIMULATOR)}
    inputs["other_network/policy"] = {"": trials(tmp_path / "other", 5, 5, world=SIMULATOR)}
    ablation_report(inputs, tmp_path, AblationReportConfig())
    assert [finding.name for finding in check_ablation_report(tmp_path) if not finding.passed] == []
    found = rows(tmp_path)
    assert found["other_network"]["over_base"] is None
    assert found["minimum_jerk"]["over_base"] is None  # its trials in the stand-in have no partner
    shown, said = table_of(tmp_path)
    assert shown["other_network"]["Average minus base (points)"] == "no placement in common"
    assert "Closed loop in the simulator that made the training data" in said
    assert "both worlds" in said


def test_a_variant_without_a_policy_of_its_own_differs_in_no_success(tmp_path, inputs):
    """What it accepts is the base's, and so is the policy."""
    del inputs["other_network/policy"]
    inputs["other_network/motion"] = inputs["policy"]
    ablation_report(inputs, tmp_path, AblationReportConfig())
    assert table_of(tmp_path)[0]["other_network"]["Average minus base (points)"] == "None"


def test_where_networks_differ_the_interval_of_a_variants_success_is_wider(tmp_path, inputs):
    """Twenty trials of two networks, in ten of which the one succeeds and in none the other."""
    alike, apart = (trials(tmp_path / name, 10, 10, seeds=2) for name in ("alike", "apart"))
    table = pd.read_parquet(apart / "evaluation.parquet")
    table.loc[table["trained_on"] == "generated", "success"] = table["seed"] == 0
    table.to_parquet(apart / "evaluation.parquet")
    ablation_report(
        {**inputs, "other_network/policy": {"": apart}, "policy": {"": alike}}, tmp_path, AblationReportConfig()
    )
    found = {name: row["all_trials"]["interval"] for name, row in rows(tmp_path).items()}
    assert found["base"] == pytest.approx([0.299, 0.701], abs=1e-3)
    assert found["other_network"][0] < 0.05
    assert found["other_network"][1] > 0.95


def test_base_alone_compares_nothing_and_says_so(tmp_path, inputs):
    base = {name: inputs[name] for name in ("valid_trajectories", "policy")}
    ablation_report(base, tmp_path, AblationReportConfig())
    assert "compares nothing" in (tmp_path / "report.html").read_text()


def test_no_trials_are_no_rate(tmp_path, inputs):
    empty = pd.read_parquet(tmp_path / "bp" / "evaluation.parquet").iloc[:0]
    empty.to_parquet(inputs["policy"][""] / "evaluation.parquet")
    ablation_report(inputs, tmp_path, AblationReportConfig())
    assert rows(tmp_path)["base"]["success_rate"] is None
    assert "not run" in (tmp_path / "report.html").read_text()


def test_a_damaged_table_is_named(tmp_path, inputs):
    (inputs["minimum_jerk/policy"][""] / "evaluation.parquet").write_bytes(b"PAR1")
    with pytest.raises(BadInput, match=r"mp/evaluation\.parquet"):
        ablation_report(inputs, tmp_path, AblationReportConfig())


def test_check_sees_a_rate_that_does_not_follow(tmp_path, inputs):
    ablation_report(inputs, tmp_path, AblationReportConfig())
    table = json.loads((tmp_path / "table.json").read_text())
    table["rows"][1]["pass_rate"] = 0.9
    (tmp_path / "table.json").write_text(json.dumps(table))
    assert [f.name for f in check_ablation_report(tmp_path) if not f.passed] == ["intervals_hold_their_values"]


def test_check_sees_counts_that_do_not_fit_together(tmp_path, inputs):
    ablation_report(inputs, tmp_path, AblationReportConfig())
    table = json.loads((tmp_path / "table.json").read_text())
    table["rows"][2]["shifts"][0]["trial_count"] = 9
    table["rows"][1]["accepted_and_successful_count"] = 3
    (tmp_path / "table.json").write_text(json.dumps(table))
    [finding] = [f for f in check_ablation_report(tmp_path) if not f.passed]
    assert finding.name == "counts_fit_together"
    assert "['minimum_jerk', 'other_network']" in finding.detail
