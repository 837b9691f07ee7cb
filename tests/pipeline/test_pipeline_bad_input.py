"""What a person sees who gives the project a wrong file: through `sim1 run`, on the project's own graph."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

REPOSITORY = Path(__file__).parents[2]


def sim1(root: Path, *arguments: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-c", "from assets_defs.cli import main; main()", *arguments]
    environment = {**os.environ, "SIM1_HOME": str(root), "PYTHONPATH": str(REPOSITORY), "COLUMNS": "400"}
    environment.pop("SIM1_PROFILE", None)
    return subprocess.run(command, env=environment, cwd=root, capture_output=True, text=True, timeout=280)


def made(root: Path, *more: str) -> subprocess.CompletedProcess:
    return sim1(root, "run", "--profile", "smoke", "--garment", "towel", "--select", "scan", *more)


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A home with the shipped towel, its scan made."""
    root = tmp_path_factory.mktemp("bad") / "home"
    (root / "data" / "garments").mkdir(parents=True)
    (root / "data" / "tasks").mkdir()
    for file in ("dagster.yaml", "data/prices.yaml", "data/garments/towel.yaml", "data/tasks/towel.yaml"):
        shutil.copy(REPOSITORY / file, root / file)
    for folder in ("scans/towel", "robot", "environment"):
        shutil.copytree(REPOSITORY / "data" / folder, root / "data" / folder)
    answer = made(root)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    return root


@pytest.fixture
def home(good: Path, tmp_path: Path) -> Path:
    root = tmp_path / "home"
    shutil.copytree(good, root)
    return root


def rewrite_cloud(root: Path, change: Callable[[np.ndarray], np.ndarray]) -> None:
    """The towel's scan without colours and poses, its points changed."""
    folder = root / "data" / "scans" / "towel"
    points = np.asarray(trimesh.load(folder / "scan.ply", process=False).vertices)
    for extra in ("truth.npz", "views.json"):
        (folder / extra).unlink()
    garment = root / "data" / "garments" / "towel.yaml"
    garment.write_text(garment.read_text().replace("virtual: true", "virtual: false"))
    lines = ["ply", "format ascii 1.0", f"element vertex {len(change(points))}"]
    lines += [f"property float {axis}" for axis in "xyz"] + ["end_header"]
    rows = [" ".join(f"{value:.6f}" for value in point) for point in change(points)]
    (folder / "scan.ply").write_text("\n".join(lines + rows) + "\n")


def with_nan(points: np.ndarray) -> np.ndarray:
    points = points.copy()
    points[7, 1] = np.nan
    return points


CLOUDS = {
    "empty": (lambda points: points[:0], r"scan\.ply.*empty"),
    "not a number": (with_nan, r"scan\.ply.*(NaN|nan|not finite)"),
    "millimetres": (lambda points: 1000.0 * points, r"scan\.ply.*mm"),
    "inches": (lambda points: points / 0.0254, r"scan\.ply.*in"),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_a_wrong_cloud_is_named_with_its_remedy_and_the_good_artifact_stays(home, name):
    change, message = CLOUDS[name]
    before = (home / "data/store/scan/towel/artifact.json").read_bytes()
    rewrite_cloud(home, change)
    answer = made(home)
    said = answer.stdout + answer.stderr
    assert answer.returncode != 0
    assert re.search(message, said), said[-1500:]
    assert "Traceback" not in said
    assert (home / "data/store/scan/towel/artifact.json").read_bytes() == before


@pytest.mark.parametrize(
    ("spoil", "names"),
    [
        (lambda root: (root / "data/scans/towel/scan.ply").unlink(), ["data/scans/towel", "scan"]),
        (lambda root: shutil.rmtree(root / "data/scans/towel"), ["towel", "scans"]),
        (
            lambda root: (root / "data/garments/towel.yaml").write_text(
                (root / "data/garments/towel.yaml").read_text() + "colour: blue\n"
            ),
            ["towel.yaml", "colour"],
        ),
    ],
    ids=["no scan file", "no scan folder", "unknown key"],
)
def test_a_missing_file_and_an_unknown_key_are_named(home, spoil, names):
    spoil(home)
    answer = made(home)
    said = answer.stdout + answer.stderr
    assert answer.returncode != 0
    assert all(name in said for name in names), said[-1500:]
    assert "Traceback" not in said


def test_a_damaged_artifact_is_seen_and_made_again(home):
    damaged = next((home / "data/store/scan/towel").glob("*.npz"))
    good = damaged.read_bytes()
    damaged.write_bytes(good[:-100])
    assert "damaged" in sim1(home, "status").stdout
    answer = made(home)
    assert answer.returncode == 0, answer.stdout + answer.stderr
    assert damaged.read_bytes() == good
