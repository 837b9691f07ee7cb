"""A small dataset as the stage writes it, whole and as a copy to damage."""

import shutil
from pathlib import Path

import pytest
from rendered_towel import ROBOT, write_rendered

from sim1.dataset.stage import DatasetConfig, dataset


@pytest.fixture(scope="session")
def good(tmp_path_factory) -> Path:
    """Nobody changes it."""
    folder = tmp_path_factory.mktemp("good_dataset")
    (folder / "out").mkdir()
    rendered = write_rendered(folder / "towel")
    dataset({"robot": ROBOT, "rendered_episodes": {"towel": rendered}}, folder / "out", DatasetConfig(keypoint_count=4))
    return folder / "out"


@pytest.fixture
def artifact(good, tmp_path) -> Path:
    """A copy of it."""
    return shutil.copytree(good, tmp_path / "artifact")
