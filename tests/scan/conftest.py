"""A small virtual scan, and a garment folder that a test may damage."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim1.scan.stage import ScanConfig, scan
from sim1.scan.virtual.garments import towel
from sim1.scan.virtual.scanner import Scanner
from sim1.scan.virtual.session import scan_garment

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def small_scan(tmp_path_factory) -> Path:
    """Folder of a coarse virtual scan of the towel, made once."""
    folder = tmp_path_factory.mktemp("small") / "towel"
    scan_garment(folder, replace(towel(), cell_m=0.004), seed=3, name="towel", scanner=Scanner(width=110, height=110))
    return folder


@pytest.fixture
def garment_file(tmp_path) -> Path:
    """A copy of the towel's garment file, declared as not virtual so that plain files go with it."""
    path = tmp_path / "garment.yaml"
    text = (ROOT / "data/garments/towel.yaml").read_text()
    path.write_text(text.replace("virtual: true", "virtual: false"))
    return path


@pytest.fixture
def ingest_plain(tmp_path, garment_file):
    """Function that runs the scan stage on a folder and returns the artifact's folder."""

    def run(folder: Path, garment: Path = garment_file, **config) -> Path:
        out = tmp_path / f"artifact_{len(list(tmp_path.glob('artifact_*')))}"
        out.mkdir()
        scan({"garment": {"g": garment}, "scans": {"g": folder}}, out, ScanConfig(**config))
        return out

    return run


@pytest.fixture
def sheet() -> dict[str, np.ndarray]:
    """Vertex columns of a coloured 0.4 x 0.3 m sheet of 1900 points."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 50), np.linspace(-0.15, 0.15, 38))
    points = np.stack([x.ravel(), y.ravel(), 0.01 * np.sin(20 * x.ravel())], axis=1).astype(np.float32)
    colors = rng.integers(0, 255, (len(points), 3)).astype(np.uint8)
    return dict(zip("xyz", points.T, strict=True)) | dict(zip(("red", "green", "blue"), colors.T, strict=True))
