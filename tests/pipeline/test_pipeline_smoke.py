"""The whole pipeline on one garment in its smallest size: real work in every stage, twice."""

import html
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline import Home, load_graph

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    """A home with the shipped towel alone and the project's own graph."""
    root = tmp_path_factory.mktemp("smoke") / "home"
    (root / "data" / "garments").mkdir(parents=True)
    shutil.copy(REPOSITORY / "dagster.yaml", root)
    shutil.copy(REPOSITORY / "data" / "prices.yaml", root / "data")
    shutil.copy(REPOSITORY / "data" / "garments" / "towel.yaml", root / "data" / "garments")
    (root / "data" / "tasks").mkdir()
    shutil.copy(REPOSITORY / "data" / "tasks" / "towel.yaml", root / "data" / "tasks")
    for folder in ("scans/towel", "robot", "environment"):
        shutil.copytree(REPOSITORY / "data" / folder, root / "data" / folder)
    return Home(root)


def sim1(home: Home, *arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-c", "from assets_defs.cli import main; main()", *arguments]
    environment = {**os.environ, "SIM1_HOME": str(home.root), "PYTHONPATH": str(REPOSITORY), "COLUMNS": "200"}
    environment.pop("SIM1_PROFILE", None)
    return subprocess.run(command, env=environment, cwd=home.root, capture_output=True, text=True, timeout=1500)


@pytest.mark.timeout(1500)
def test_a_scan_becomes_a_dataset_and_a_curve_and_a_second_run_makes_nothing(home):
    answer = sim1(home, "run", "--profile", "smoke", "--variant", "base")
    assert answer.returncode == 0, answer.stdout[-4000:] + answer.stderr[-4000:]
    graph = load_graph(home, "smoke")
    base = [node for node in graph.nodes.values() if not node.variant and not node.stage.compares]
    assert f"{len(base)} made, 0 fresh already, 0 failed, 0 waiting" in answer.stdout
    assert "dataset: data/store/dataset/_/lerobot" in answer.stdout
    page = html.unescape((home.store / "report.html").read_text())
    assert [node.id for node in base if node.stage.summary not in page] == []

    again = sim1(home, "run", "--profile", "smoke", "--variant", "base")
    assert f"0 made, {len(base)} fresh already" in again.stdout

    rows = json.loads(sim1(home, "status", "--profile", "smoke", "--json").stdout)
    assert rows["profile"] == "smoke"
    ancestry = json.loads(sim1(home, "audit", "dataset", "--json").stdout)["ancestry"]
    assert {"scan/towel", "calibrated_physics/towel", "seed_demos/towel", "rendered_episodes/towel"} <= set(ancestry)


def test_every_artifact_has_its_figures_and_the_ui_its_pictures(home):
    for record in sorted(home.store.glob("*/*/artifact.json")):
        found = json.loads(record.read_text())
        assert found["facts"], record
        assert all(finding["passed"] for finding in found["findings"] if finding["blocking"]), record
    assert len(list(home.store.glob("*/*/*.png"))) >= 10
