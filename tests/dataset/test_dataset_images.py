"""Pictures that lie in the tables, as LeRobot's own writer puts them there, are decoded and held to their feature."""

import io
import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from sim1.dataset.check import check_lerobot

HEIGHT, WIDTH = 24, 32
FEATURES = {
    "pose": {"dtype": "float32", "shape": (3,), "names": ["x", "y", "heading"]},
    "wheel_speed": {"dtype": "float32", "shape": (2,), "names": None},
    "eyes.front": {"dtype": "image", "shape": (HEIGHT, WIDTH, 3), "names": ["height", "width", "channels"]},
    "eyes.back": {"dtype": "image", "shape": (3, HEIGHT, WIDTH), "names": ["channels", "height", "width"]},
}


@pytest.fixture(scope="module")
def rover(tmp_path_factory) -> Path:
    """Two episodes of another robot, made by LeRobot's API alone."""
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    root = tmp_path_factory.mktemp("rover") / "data"
    stream = np.random.default_rng(1)
    made = LeRobotDataset.create(repo_id="someone/rover", fps=12, features=FEATURES, root=root, use_videos=False)
    for length in (4, 3):
        for _ in range(length):
            front = stream.integers(0, 255, (HEIGHT, WIDTH, 3)).astype(np.uint8)
            made.add_frame(
                {
                    "pose": stream.normal(size=3).astype(np.float32),
                    "wheel_speed": stream.normal(size=2).astype(np.float32),
                    "eyes.front": front,
                    "eyes.back": front[::-1].transpose(2, 0, 1),
                    "task": "drive round the table",
                }
            )
        made.save_episode()
    made.finalize()
    return root


def faults(root: Path) -> dict[str, str]:
    return {finding.name: finding.detail for finding in check_lerobot(root) if not finding.passed}


def test_what_lerobot_writes_passes(rover):
    assert faults(rover) == {}
    said = {finding.name: finding.detail for finding in check_lerobot(rover)}
    assert said["images_readable"] == "14 pictures of 2 features"


def png(*size: int, mode: str = "RGB") -> dict:
    file = io.BytesIO()
    Image.new(mode, size).save(file, "PNG")
    return {"bytes": file.getvalue(), "path": None}


def not_a_number() -> dict:
    file = io.BytesIO()
    Image.fromarray(np.full((HEIGHT, WIDTH), np.nan, np.float32)).save(file, "TIFF")
    return {"bytes": file.getvalue(), "path": None}


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        ({"bytes": b"\x89PNG, cut off", "path": None}, "eyes.front cannot be decoded"),
        ({"bytes": png(WIDTH, HEIGHT)["bytes"][:50], "path": None}, "eyes.front cannot be decoded"),
        ({"bytes": None, "path": None}, "eyes.front cannot be decoded (neither bytes nor a path)"),
        ({"bytes": None, "path": "images/gone.png"}, "eyes.front cannot be decoded ([Errno 2]"),
        (png(HEIGHT, WIDTH), "eyes.front is 32 x 24 x 3, expected 24 x 32 x 3 (height, width, channels)"),
        (png(WIDTH, HEIGHT, mode="RGBA"), "eyes.front is 24 x 32 x 4, expected 24 x 32 x 3"),
    ],
    ids=["no picture", "cut off", "nothing", "a file that is gone", "turned", "too many channels"],
)
def test_a_picture_that_is_none_or_of_another_shape_is_named_with_file_and_row(rover, tmp_path, cell, said):
    root = with_cell(rover, tmp_path / "data", cell)
    assert f"data/chunk-000/file-000.parquet row 5: {said}" in faults(root)["images_readable"]


def test_depths_that_are_no_numbers_are_named(rover, tmp_path):
    root = with_cell(rover, tmp_path / "data", not_a_number())
    path = root / "meta/info.json"
    info = json.loads(path.read_text())
    info["features"]["eyes.front"]["shape"] = [HEIGHT, WIDTH, 1]
    path.write_text(json.dumps(info))
    assert "row 0: eyes.front is 24 x 32 x 3, expected 24 x 32 x 1" in faults(root)["images_readable"]
    table = pd.read_parquet(root / "data/chunk-000/file-000.parquet")
    table["eyes.front"] = table["eyes.front"].iloc[[5] * len(table)].tolist()
    table.to_parquet(root / "data/chunk-000/file-000.parquet", index=False)
    assert f"row 0: eyes.front has {HEIGHT * WIDTH} values that are not finite" in faults(root)["images_readable"]


def with_cell(rover: Path, root: Path, cell: dict) -> Path:
    """A copy with that in place of a picture in row 5."""
    shutil.copytree(rover, root)
    path = root / "data/chunk-000/file-000.parquet"
    table = pd.read_parquet(path)
    cells = table["eyes.front"].tolist()
    cells[5] = cell
    table.assign(**{"eyes.front": cells}).to_parquet(path, index=False)
    return root
