"""Two hands take the near edge of a small towel, fold it in half by friction alone, and let go."""

import numpy as np
import pytest
from avbd_sheets import DEVICE

from sim1.cloth.config import CellConfig
from sim1.cloth.garment import grid_towel
from sim1.cloth.physics import ClothPhysics, Property
from sim1.cloth.world import ClothWorld
from sim1.validity.penetration import crossings

VALUES = {
    "area_density_kg_m2": 0.3,
    "thickness_m": 0.002,
    "stretch_n_m": 400.0,
    "poisson": 0.3,
    "bending_n_m": 2e-5,
    "damping_s": 1e-3,
}
CLOTH = ClothPhysics(**{name: Property(value=value) for name, value in VALUES.items()})
TOWEL = grid_towel(0.24, 0.24, 0.02)
OPEN_M = 0.036


def tool(x: float, y: float, z: float) -> np.ndarray:
    """Fingers down, opening along x, across the fold."""
    pose = np.eye(4)
    pose[:3, :3] = np.stack([[0, 0, -1], [1, 0, 0], [0, -1, 0]], axis=1)
    pose[:3, 3] = x, y, z
    return pose


def hands(x: float, z: float) -> np.ndarray:
    return np.stack([tool(x, 0.09, z), tool(x, -0.09, z)])


def smooth(share: np.ndarray) -> np.ndarray:
    return share**3 * (10 - 15 * share + 6 * share**2)


@pytest.fixture(scope="module")
def fold() -> dict[str, np.ndarray]:
    world = ClothWorld(TOWEL, CLOTH, CellConfig(), device=DEVICE)
    start = TOWEL.rest_m + np.array([0, 0, 0.002])
    world.reset(start, hands(-0.105, 0.08), np.full(2, OPEN_M))
    local, heights = [], []

    def go(path: list[tuple[float, float]], gaps: np.ndarray) -> None:
        for (x, z), gap in zip(path, gaps):
            world.step(hands(x, z), np.full(2, gap))
            heights.append(world.garment_m[:, 2].max())
            tools = world.tools
            local.append([(world.garment_m - pose[:3, 3]) @ pose[:3, :3] for pose in tools])

    down = smooth(np.linspace(0, 1, 16))
    go([(-0.105, 0.08 - 0.0795 * s) for s in down], np.full(16, OPEN_M))
    go([(-0.105, 0.0005)] * 16, OPEN_M * (1 - smooth(np.linspace(0, 1, 16))))
    closed = len(local)
    share = smooth(np.linspace(0, 1, 60))
    arc = [(-0.105 + 0.2 * s, 0.0005 + 0.012 * s + 0.09 * np.sin(np.pi * s)) for s in share]
    go(arc, np.zeros(60))
    carried = len(local)
    go([arc[-1]] * 12, OPEN_M * smooth(np.linspace(0, 1, 12)))
    go([(arc[-1][0], arc[-1][1] + 0.1 * s) for s in smooth(np.linspace(0, 1, 20))], np.full(20, OPEN_M))
    go([(arc[-1][0], arc[-1][1] + 0.1)] * 30, np.full(30, OPEN_M))
    return {
        "start": start,
        "end": world.garment_m,
        "local": np.array(local),
        "closed": np.array(closed),
        "carried": np.array(carried),
        "heights": np.array(heights),
    }


def test_the_cloth_between_the_pads_does_not_slip_beyond_5_mm_on_its_way(fold):
    first, last = fold["local"][int(fold["closed"]) + 2], fold["local"][int(fold["carried"]) - 1]
    between = (np.abs(first[..., 1]) < 0.006) & (np.abs(first[..., 2]) < 0.011) & (np.abs(first[..., 0] + 0.02) < 0.02)
    assert between.any(axis=1).all()  # both hands hold something
    assert np.linalg.norm(last - first, axis=2)[between].max() < 0.005


def test_the_near_edge_is_lifted_and_comes_to_lie_near_the_far_one(fold):
    assert fold["heights"].max() > 0.07
    near, far = fold["start"][:, 0] < -0.119, fold["start"][:, 0] > 0.119
    assert np.abs(fold["end"][near, 0].mean() - fold["end"][far, 0].mean()) < 0.05
    assert np.ptp(fold["end"][:, 0]) < 0.75 * np.ptp(fold["start"][:, 0])


def test_no_layer_has_passed_through_another_at_the_end(fold):
    assert len(crossings(fold["end"], TOWEL.faces)) == 0
