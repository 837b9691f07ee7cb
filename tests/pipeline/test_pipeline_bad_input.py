"""What a person sees who gives the project a wrong file: through `sim1 run`, on the project's own graph.

Every start of the program takes seconds, so all scans are made in one run, all faults but those of the garment files are met
in a second one, and the tests read what it said.
"""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from sim1.scan.ply import read_ply

REPOSITORY = Path(__file__).parents[2]


def with_nan(points: np.ndarray) -> np.ndarray:
    points = points.copy()
    points[7, 1] = np.nan
    return points


CLOUDS: dict[
    str, tuple[Callable[[np.ndarray], np.ndarray], str]
] = {  # garment -> what happens to its scan, what is said
    "empty": (lambda points: points[:0], r"scan\.ply.*empty"),
    "not-a-number": (with_nan, r"scan\.ply.*(NaN|nan|not finite)"),
    "millimetres": (lambda points: 1000.0 * points, r"scan\.ply.*\bmm\b"),
    "inches": (lambda points: points / 0.0254, r"scan\.ply.*\bin\b"),
}


@dataclass(frozen=True)
class Said:
    """What became of the home, and what the program said on the way."""

    root: Path
    good: dict[str, dict[str, bytes]]  # garment -> name -> bytes of its scan artifact, before anything was spoilt
    status: subprocess.CompletedProcess  # after it
    run: subprocess.CompletedProcess

    def of(self, garment: str) -> str:
        """The one line on why there is no new scan of a garment."""
        (line,) = [line for line in self.run.stdout.splitlines() if line.startswith(f"failed scan/{garment}: ")]
        return line


def sim1(root: Path, *arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-c", "from assets_defs.cli import main; main()", *arguments]
    environment = {**os.environ, "SIM1_HOME": str(root), "PYTHONPATH": str(REPOSITORY), "COLUMNS": "400"}
    environment.pop("SIM1_PROFILE", None)
    return subprocess.run(command, env=environment, cwd=root, capture_output=True, text=True, timeout=280)


def make_scans(root: Path, *more: str) -> subprocess.CompletedProcess:
    return sim1(root, "run", "--profile", "smoke", "--select", "scan", *more)


def write_cloud(root: Path, garment: str, points: np.ndarray) -> None:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    lines += [f"property float {axis}" for axis in "xyz"] + ["end_header"]
    rows = [" ".join(f"{value:.6f}" for value in point) for point in points]
    (root / "data" / "scans" / garment / "scan.ply").write_text("\n".join(lines + rows) + "\n")


def artifact_of(root: Path, garment: str) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (root / "data/store/scan" / garment).iterdir()}


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> Said:
    """Garments with a thinned scan of the shipped towel, all made; then all but one spoilt, and made again."""
    root = tmp_path_factory.mktemp("bad") / "home"
    (root / "data" / "garments").mkdir(parents=True)
    shutil.copy(REPOSITORY / "dagster.yaml", root)
    vertex, _ = read_ply(REPOSITORY / "data/scans/towel/scan.ply")
    points = np.stack([vertex[axis] for axis in "xyz"], axis=1)[::10]
    text = (REPOSITORY / "data/garments/towel.yaml").read_text().replace("virtual: true", "virtual: false")
    names = ["towel", "no-file", *CLOUDS]
    for name in names:
        (root / "data" / "garments" / f"{name}.yaml").write_text(text)
        (root / "data" / "scans" / name).mkdir(parents=True)
        write_cloud(root, name, points)
    answer = make_scans(root, "--jobs", "0")
    assert answer.returncode == 0, answer.stdout + answer.stderr
    good = {name: artifact_of(root, name) for name in names}

    for name, (change, _) in CLOUDS.items():
        write_cloud(root, name, change(points))
    (root / "data/scans/no-file/scan.ply").unlink()
    damaged = root / "data/store/scan/towel/points.npz"
    damaged.write_bytes(damaged.read_bytes()[:-100])
    return Said(root, good, sim1(root, "status", "--profile", "smoke"), make_scans(root, "--jobs", "1"))


@pytest.mark.parametrize("name", CLOUDS)
def test_a_wrong_cloud_is_named_with_its_remedy_and_the_good_artifact_stays(said, name):
    assert re.search(CLOUDS[name][1], said.of(name))
    assert artifact_of(said.root, name) == said.good[name]


def test_a_missing_scan_file_is_named_and_the_good_artifact_stays(said):
    assert "data/scans/no-file: no scan" in said.of("no-file")
    assert artifact_of(said.root, "no-file") == said.good["no-file"]


def test_a_damaged_artifact_is_seen_and_made_again(said):
    assert re.search(r"scan/towel: damaged: points\.npz", said.status.stdout)
    assert "scan/towel: made" in said.run.stdout
    record, before = artifact_of(said.root, "towel"), dict(said.good["towel"])
    assert record.pop("artifact.json")
    before.pop("artifact.json")  # says when and how fast
    assert record == before


def test_the_run_ends_as_failed_and_no_fault_is_a_traceback(said):
    assert said.run.returncode == 1
    assert "1 made, 0 fresh already, 5 failed" in said.run.stdout
    assert "Traceback" not in said.run.stdout + said.run.stderr


def test_files_of_the_person_are_read_before_any_work_and_all_their_faults_told_at_once(said, tmp_path):
    root = tmp_path / "home"
    shutil.copytree(said.root, root)
    for folder in ("robot", "environment", "tasks"):
        shutil.copytree(REPOSITORY / "data" / folder, root / "data" / folder)
    shutil.rmtree(root / "data" / "scans" / "inches")
    with (root / "data" / "garments" / "empty.yaml").open("a") as file:
        file.write("colour: blue\n")
    task = root / "data" / "tasks" / "towel.yaml"
    task.write_text(task.read_text().replace("carry_s", "cary_s"))
    names = ("towel", "empty", "inches")
    options = [word for name in names for word in ("--garment", name)]
    answer = sim1(root, "run", "--profile", "smoke", "--select", "seed_demos", *options)
    assert answer.returncode == 2
    assert answer.stdout == ""
    assert set(answer.stderr.splitlines()[1:]) == {
        "  data/garments/empty.yaml: unknown key 'colour'; remove it or correct its spelling",
        "  data/scans/inches: missing; stage scan needs it (its source 'scans')",
        "  data/tasks/towel.yaml: unknown key 'steps.0.cary_s'; remove it or correct its spelling",
        "  data/tasks/empty.yaml: missing; stage seed_demos needs it (its source 'task')",
        "  data/tasks/inches.yaml: missing; stage seed_demos needs it (its source 'task')",
    }
    assert not (root / "data" / "store" / "recordings").exists()
