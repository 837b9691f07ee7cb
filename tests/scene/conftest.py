from pathlib import Path

import numpy as np
import pytest
from scene_garments import shirt_points, towel_points, write_mesh

DATA = Path(__file__).parents[2] / "data"


@pytest.fixture(scope="session")
def inputs_in():
    def make(folder: Path, grid: np.ndarray, garment: str = "towel") -> dict:
        return {
            "garment_mesh": {garment: write_mesh(folder / "mesh" / garment, grid)},
            "robot": {"": DATA / "robot"},
            "environment": {"": DATA / "environment"},
        }

    return make


@pytest.fixture
def scene_inputs(inputs_in, tmp_path):
    return lambda grid, garment="towel": inputs_in(tmp_path, grid, garment)


@pytest.fixture
def towel():
    return towel_points()


@pytest.fixture
def shirt():
    return shirt_points()


@pytest.fixture
def blanket():
    return towel_points(1.0, 1.4)
