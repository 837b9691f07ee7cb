"""The page of all results: what was found beside the paper's figures, film strips, and what was not run."""

import json
from pathlib import Path

import pandas as pd
import pytest
from matplotlib.figure import Figure

from sim1.policy import paper
from sim1.policy.ablation import PAPER_METHODS
from sim1.policy.ablation import SCHEMA as ABLATION_SCHEMA
from sim1.policy.cost_page import SCHEMA as COST_SCHEMA
from sim1.policy.experiment import ABOUT_SCHEMA
from sim1.policy.image.measures import SCHEMA as IMAGE_SCHEMA
from sim1.policy.lessons import GENERATED, REAL
from sim1.policy.results_page import PARTS, results
from sim1.policy.stage import (
    AblationReportConfig,
    CostReportConfig,
    ScalingReportConfig,
    ablation_report,
    cost_report,
    scaling_report,
)
from sim1.policy.worlds import REALITY
from sim1.report import write_report

ROOT = Path(__file__).parents[2]
NOTHING = {part.stage: {} for part in PARTS}


def a_policy(folder, seeds=(0,)):
    """Trials of a towel in-domain and moved; 20 of 30 succeed after 16 generated trajectories, 10 of 30 after 8 real ones."""
    folder.mkdir()
    rows = [
        {
            "world": REALITY, "trained_on": kind, "size": size, "seed": seed, "garment": "towel", "shift": shift, "trial": number,
            "success": number < wins, "failure": None if number < wins else "slip",
        }
        for kind, size, wins in ((GENERATED, 2, 1), (GENERATED, 16, 20), (REAL, 8, 10))
        for shift in ("in-domain", "spatial")
        for seed in seeds
        for number in range(30)
    ]  # fmt: skip
    pd.DataFrame(rows).to_parquet(folder / "evaluation.parquet")
    errors = {
        "trained_on": [],
        "tested_on": [],
        "size": [],
        "seed": [],
        "garment": [],
        "trajectory": [],
        "source": [],
        "joint_error_rad": [],
    }
    pd.DataFrame(errors).to_parquet(folder / "open_loop.parquet")
    lessons = {
        kind: {"available_count": 16, "held_out_count": 0, "sizes": sizes, "splits": [{"garment": "towel"}]}
        for kind, sizes in ((GENERATED, [2, 16]), (REAL, [8]))
    }
    trials = {
        "each": 30,
        "models": {},
        "garments": ["towel"],
        "shifts": ["in-domain", "spatial"],
        "friction_factors": [],
        "time_factor": 1.2,
        "time_limits": {"towel": {"duration_s": 9.0, "longest_of": REAL}},
    }
    about = {
        "schema": ABOUT_SCHEMA,
        "lessons": lessons,
        "seeds": [0],
        "no_real_demonstrations": None,
        "trials": {**trials, "laid_m": 0.01, "shift_m": 0.08, "turn_rad": 0.26},
    }
    (folder / "policy.json").write_text(json.dumps(about))
    for shift in ("in-domain", "spatial"):
        Figure(figsize=(1, 1)).savefig(folder / f"trials_{shift}.png")
    return folder


def decisions(folder):
    """Six accepted, three that slipped, one that the rules rejected; and one disturbed on purpose."""
    folder.mkdir()
    judged = (
        [(None, "")] * 6
        + [("slip", "judge: slip")] * 3
        + [(None, "rules: end.iou <= 1, is 2"), ("slip", "judge: slip")]
    )
    rows = [
        {
            "success": failure is None,
            "failure": failure,
            "reasons": reasons,
            "accepted": not reasons,
            "perturbed": at == 10,
        }
        for at, (failure, reasons) in enumerate(judged)
    ]
    pd.DataFrame(rows).to_parquet(folder / "decisions.parquet")
    Figure(figsize=(1, 1)).savefig(folder / "film_strips.png")
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Artifacts of a run without image policy, one of whose variants stands for a method of the paper."""
    root = tmp_path_factory.mktemp("made")
    found = {**NOTHING, "policy": {"": a_policy(root / "p")}, "valid_trajectories": {"towel": decisions(root / "v")}}
    reports = {name: root / name for name in ("scaling_report", "ablation_report", "cost_report")}
    for folder in reports.values():
        folder.mkdir()
    base = {name: found[name] for name in ("policy", "valid_trajectories")}
    variant = {f"calibrated/{name}": artifacts for name, artifacts in base.items()}
    scaling_report(base, reports["scaling_report"], ScalingReportConfig())
    ablation_report({**base, **variant}, reports["ablation_report"], AblationReportConfig())
    shown = {"dataset": {"": root / "d"}, "prices": {"": ROOT / "data" / "prices.yaml"}}
    (root / "d").mkdir()
    pd.DataFrame({"garment": ["towel"], "trajectory": ["0000"]}).to_parquet(root / "d" / "provenance.parquet")
    cost_report({**base, **shown}, reports["cost_report"], CostReportConfig())
    return found | {name: {"": folder} for name, folder in reports.items()}


def section(sections, heading):
    [found] = [one for one in sections if one.heading == heading]
    return found


def rows_of(sections, heading):
    """Rows of a section's table by their first cell."""
    return {next(iter(row.values())): row for row in section(sections, heading).table}


def plain(cell):
    return cell.replace("\N{NO-BREAK SPACE}", " ")


def test_success_by_shift_has_counts_an_interval_and_the_papers_figure_beside_it(made):
    rows = rows_of(results(made, {}), "Success by shift")
    assert list(rows) == [*paper.SHIFTS, "average"]
    spatial = rows["spatial"]
    assert plain(spatial["Generated trajectories, 16 | here"]) == "67 (49 to 81), 20 of 30"
    assert spatial["Generated trajectories, 16 | paper"] == 93
    assert plain(spatial["Generated minus real | here"]) == "+33 (+14 to +48), 30 pairs"
    assert spatial["Generated minus real | paper"] == "+50"
    assert rows["lighting"]["Generated trajectories, 16 | here"] == "not run"
    assert rows["lighting"]["Generated trajectories, 16 | paper"] == 82
    assert rows["average"]["Demonstrations in the simulator | here"] == "not run"
    assert rows["average"]["Demonstrations in the simulator | paper"] == 87


def test_what_intervals_of_one_network_do_not_hold_is_said_where_they_stand(made, tmp_path):
    sections = results(made, {})
    for heading in ("Scaling curves", "Success by shift", "Success by garment"):
        said = " ".join(section(sections, heading).paragraphs)
        assert "One network alone drove everywhere here" in said
        assert "what another network would do is not in it" in said
    (tmp_path / "s").mkdir()
    a_policy(tmp_path / "p", seeds=(0, 1))
    scaling_report({"policy": {"": tmp_path / "p"}}, tmp_path / "s", ScalingReportConfig())
    sections = results({"scaling_report": {"": tmp_path / "s"}}, {})
    said = " ".join(section(sections, "Success by shift").paragraphs)
    assert "spread between networks" in said
    assert "One network alone" not in said


def test_success_by_garment_names_those_of_the_paper_that_were_not_run(made):
    rows = rows_of(results(made, {}), "Success by garment")
    assert plain(rows["towel"]["Success (%) | here"]) == "67 (49 to 81), 20 of 30"
    assert {name: row["Success (%) | paper"] for name, row in rows.items()} == {
        "tshirt": 67, "towel": 80, "shorts": 93, "polo": 93,
    }  # fmt: skip
    assert rows["polo"]["Success (%) | here"] == "not run"


def test_the_worth_of_a_real_demonstration_stands_beside_the_papers(made):
    """Two sizes of generated trajectories make no curve, and friction was not tried."""
    rows = rows_of(results(made, {}), "Worth of a real demonstration")
    assert rows["success, in-domain"] == {
        "By": "success, in-domain",
        "Generated for one real | here": "not known",
        "Generated for one real | paper": 15,
    }
    assert rows["success, friction"]["Generated for one real | here"] == "not run"
    assert rows["success, friction"]["Generated for one real | paper"] == 5


def test_the_ablation_has_the_papers_methods_in_its_order_and_says_which_were_not_run(made):
    rows = rows_of(results(made, {}), "Ablation")
    assert list(rows) == [*PAPER_METHODS, "base (all parts)"]
    assert [row["Method | paper"] for row in rows.values()] == [*paper.ABLATION, None]
    assert plain(rows["calibrated"]["Pass rate | here"]) == "60 (31 to 83), 6 of 10"
    assert rows["calibrated"]["Pass rate | paper"] == 40
    assert rows["slicing"]["Pass rate | here"] == "not run"
    assert rows["slicing"]["Pass rate | paper"] == 0


def test_costs_reckoned_from_the_papers_prices_stand_beside_what_it_prints(made):
    rows = rows_of(results(made, {}), "Cost of a trajectory")
    simulated = rows["Simulation (paper)"]
    assert simulated["Unit cost ($/trajectory) | reckoned"] == pytest.approx(0.10, abs=0.001)
    assert simulated["Unit cost ($/trajectory) | paper"] == 0.10
    assert "not measured" in " ".join(section(results(made, {}), "Cost of a trajectory").paragraphs)


def test_film_strips_of_every_shift_and_of_generated_episodes_are_shown(made):
    sections = results(made, {})
    assert [picture.path.name for picture in section(sections, "Film strips of trials").pictures] == [
        "trials_in-domain.png",
        "trials_spatial.png",
    ]
    generated = section(sections, "Generated episodes")
    assert [picture.path.name for picture in generated.pictures] == ["film_strips.png"]
    counts = {
        row["Outcome"]: (plain(row["Attempts (%) | here"]), row["Disturbed on purpose"]) for row in generated.table
    }
    assert counts == {
        "accepted": ("60 (31 to 83), 6 of 10", 0),
        "slip": ("30 (11 to 60), 3 of 10", 1),
        "rejected by rule": ("10 (2 to 40), 1 of 10", 0),
    }


def test_what_was_not_run_says_so_in_its_place(made):
    sections = results(made, {})
    assert section(sections, "Image policy: pictures with one thing changed").paragraphs == [
        "Not run (stage image_policy)."
    ]
    nothing = results(NOTHING, {})
    assert [one.paragraphs for one in nothing[1:]] == [[f"Not run (stage {part.stage})."] for part in PARTS]


def test_a_stage_that_the_graph_does_not_have_is_not_missed():
    assert results({"dataset": {}}, {}) == []


def test_results_that_no_longer_hold_say_why(made):
    sections = results(made, {"ablation_report": "ablation_report is stale: setting width changed from 1 to 2"})
    assert section(sections, "Ablation").paragraphs[0] == (
        "Mind: ablation_report is stale: setting width changed from 1 to 2."
    )
    assert not [one for one in sections if one.heading != "Ablation" and one.paragraphs[0].startswith("Mind")]


@pytest.mark.parametrize("text", ['{"schema": "sim1.curve/2", "points": []}', "[]", "{", '{"schema": "sim1.curve/3"}'])
def test_an_artifact_of_another_version_or_damaged_is_named_and_the_others_are_shown(made, tmp_path, text):
    (tmp_path / "curve.json").write_text(text)
    sections = results({**made, "scaling_report": {"": tmp_path}}, {})
    assert sections[1].paragraphs[0].startswith("Cannot be shown: ")
    assert "curve.json" in sections[1].paragraphs[0]
    assert "make scaling_report again" in sections[1].paragraphs[0]
    assert section(sections, "Ablation").table


@pytest.mark.parametrize(
    ("stage", "file", "text"),
    [
        ("ablation_report", "table.json", json.dumps({"schema": ABLATION_SCHEMA})),
        ("cost_report", "costs.json", json.dumps({"schema": COST_SCHEMA, "methods": "none"})),
        ("image_policy", "image_policy.json", json.dumps({"schema": IMAGE_SCHEMA, "points": [{"pictures": 3}]})),
    ],
)
def test_an_artifact_whose_content_is_not_what_its_version_says_does_not_take_the_page_away(
    made, tmp_path, stage, file, text
):
    (tmp_path / file).write_text(text)
    sections = results({**made, stage: {"": tmp_path}}, {})
    [said] = [one.paragraphs[0] for one in sections if one.paragraphs[0].startswith("Cannot be shown")]
    assert f"(stage {stage})" in said
    assert section(sections, "Success by shift").table


def test_decisions_without_a_column_do_not_take_the_page_away(made, tmp_path):
    pd.DataFrame({"accepted": [True]}).to_parquet(tmp_path / "decisions.parquet")
    sections = results({**made, "valid_trajectories": {"towel": tmp_path}}, {})
    assert (
        "decisions.parquet: no column success, failure, reasons, perturbed"
        in section(sections, "Generated episodes").paragraphs[0]
    )


def test_the_page_says_what_is_a_stand_in_and_whose_figures_stand_there(made, tmp_path):
    write_report(tmp_path / "report.html", "Results", "Lead", results(made, {}))
    page = (tmp_path / "report.html").read_text()
    for words in ("scripted expert", "stand-in reality", "no robot", paper.SOURCE, "not as the same quantity"):
        assert words in page


def test_the_papers_averages_follow_from_its_shifts():
    for method in paper.ABLATION.values():
        if paper.AVERAGE in method:
            mean = sum(method[shift] for shift in paper.SHIFTS) / len(paper.SHIFTS)
            assert method[paper.AVERAGE] == pytest.approx(mean, abs=0.5)
