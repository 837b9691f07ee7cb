"""The whole pipeline on one garment in its smallest size: real work in every stage, twice."""

import html
import json
from subprocess import CompletedProcess

import pytest

from pipeline import load_graph

pytestmark = pytest.mark.timeout(1500)  # whichever test comes first has everything made


@pytest.fixture(scope="module")
def run(sim1) -> CompletedProcess:
    """What the program said that made everything in the home."""
    answer = sim1("run", "--profile", "smoke", "--variant", "base", "--jobs", "1")
    assert answer.returncode == 0, answer.stdout[-4000:] + answer.stderr[-4000:]
    return answer


def test_a_scan_becomes_a_dataset_and_a_curve_and_a_second_run_makes_nothing(home, sim1, run):
    graph = load_graph(home, "smoke")
    base = [node for node in graph.nodes.values() if not node.variant and not node.stage.compares]
    assert f"{len(base)} made, 0 fresh already, 0 failed, 0 waiting" in run.stdout
    assert "dataset: data/store/dataset/_/lerobot" in run.stdout
    page = html.unescape((home.store / "report.html").read_text())
    assert [node.id for node in base if node.stage.summary not in page] == []
    assert all(heading in page for heading in ("Success by shift", "Film strips of trials", "Generated episodes"))
    assert "Not run (stage ablation_report)." in page

    again = sim1("run", "--profile", "smoke", "--variant", "base", "--jobs", "1")
    assert f"0 made, {len(base)} fresh already" in again.stdout

    rows = json.loads(sim1("status", "--profile", "smoke", "--json").stdout)
    assert rows["profile"] == "smoke"
    ancestry = json.loads(sim1("audit", "dataset", "--json").stdout)["ancestry"]
    assert {"scan/towel", "calibrated_physics/towel", "seed_demos/towel", "rendered_episodes/towel"} <= set(ancestry)


@pytest.mark.usefixtures("run")
def test_every_artifact_has_its_figures_and_the_ui_its_pictures(home):
    records = sorted(home.store.glob("*/*/artifact.json"))
    assert records
    for record in records:
        found = json.loads(record.read_text())
        assert found["facts"], record
        assert all(finding["passed"] for finding in found["findings"] if finding["blocking"]), record
    assert len(list(home.store.glob("*/*/*.png"))) >= 10


@pytest.mark.usefixtures("run")
def test_an_episode_is_simulated_again_from_its_record_alone(home, sim1):
    demonstrated, made = (
        next(iter(sorted((home.store / stage / "towel" / "episodes").iterdir())))
        for stage in ("seed_demos", "candidate_trajectories")
    )
    assert "the same bytes" in sim1("replay", str(demonstrated)).stdout
    assert "the same bytes" in sim1("replay", str(made)).stdout
    assert "the same bytes" in sim1("replay", str(made), "--from-seed").stdout
