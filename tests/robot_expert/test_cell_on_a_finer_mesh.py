"""What plays reality is simulated on a finer mesh: whoever looks at the cell sees the garment's own vertices."""

import numpy as np
import pytest
from small_towel import TOWEL

from sim1.cloth.cell import Cell, CellConfig
from sim1.cloth.garment import read_garment_mesh
from sim1.cloth.physics import read_physics
from sim1.scene.description import read_scene

FRAMES = 6
LIFTED = (TOWEL.rest_m + np.array([0.0, 0.0, 0.05])).astype(np.float32)


def fallen(inputs, finer: bool) -> Cell:
    """A small towel that was let go 5 cm above the table."""
    mesh, scene = read_garment_mesh(inputs["garment_mesh"]["towel"]), read_scene(inputs["scene"]["towel"])
    physics = read_physics(inputs["calibrated_physics"]["towel"] / "cell.yaml")
    cell = Cell(mesh, scene, physics, CellConfig(substeps=4, iterations=2, self_contact=False, finer_mesh=finer))
    cell.reset(LIFTED, cell.joints_rad, cell.openness)
    np.testing.assert_array_equal(cell.garment_m, LIFTED)
    home = cell.joints_rad.copy()
    for _ in range(FRAMES):
        cell.step(home, np.ones(2))
    return cell


@pytest.fixture(scope="module")
def cells(inputs):
    return fallen(inputs, finer=False), fallen(inputs, finer=True)


def test_both_meshes_show_as_many_vertices_and_fall_alike(cells):
    coarse, finer = cells
    assert finer.garment_m.shape == coarse.garment_m.shape == TOWEL.rest_m.shape
    assert finer.garment_m_s.shape == TOWEL.rest_m.shape
    assert finer.garment_m.flags["C_CONTIGUOUS"]
    time_s = FRAMES / 30.0
    assert coarse.garment_m[:, 2].mean() < 0.06 - 0.4 * 9.81 * time_s**2 / 2 or coarse.garment_m[:, 2].max() < 0.01
    np.testing.assert_allclose(finer.garment_m, coarse.garment_m, atol=2e-3)


def test_the_finer_one_is_simulated_with_more_vertices_of_the_same_weight(cells):
    coarse, finer = (cell._world for cell in cells)
    weights = [1.0 / world._model.particle_inv_mass.numpy() for world in (coarse, finer)]
    assert len(weights[1]) > 1.5 * len(weights[0])
    assert weights[1].sum() == pytest.approx(weights[0].sum(), rel=1e-4)
