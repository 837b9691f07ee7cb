import numpy as np
import pytest

from sim1.scene.placement import lying_pose
from sim1.stage import BadInput


def turned(points: np.ndarray, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T


def place(points: np.ndarray, top_m: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    pose = lying_pose(points, top_m, 0.003)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    return pose, points @ pose[:3, :3].T + pose[:3, 3]


@pytest.mark.parametrize("degrees", [0.0, 17.0, -60.0, 90.0, 140.0])
def test_a_lying_towel_gets_its_long_side_along_y_however_it_was_scanned(towel, degrees):
    _, lying = place(turned(towel.reshape(-1, 3), degrees), top_m=0.1)
    np.testing.assert_allclose(np.ptp(lying, axis=0), [0.4, 0.6, 0.0], atol=1e-6)
    np.testing.assert_allclose(lying.mean(axis=0), [0, 0, 0.103], atol=1e-6)


def test_a_square_cloth_is_turned_by_45_degrees_at_most():
    x, y = np.meshgrid(np.linspace(0, 0.5, 11), np.linspace(0, 0.5, 11))
    square = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], -1)
    for degrees in (-44, -20, 0, 20, 44):
        pose, _ = place(turned(square, degrees))
        assert pose[1, 1] > np.cos(np.radians(46))


@pytest.mark.parametrize("degrees", [0.0, 12.0, -25.0])
def test_a_shirt_from_the_mannequin_lies_on_its_back_with_the_collar_towards_the_robot(shirt, degrees):
    _, lying = place(turned(shirt.reshape(-1, 3), degrees))
    np.testing.assert_allclose(np.ptp(lying, axis=0), [0.6, 0.54, 0.2], atol=0.01)
    standing = shirt.reshape(-1, 3)
    collar, hem = (lying[np.isclose(standing[:, 2], z)] for z in (1.5, 0.9))
    assert collar[:, 0].max() < -0.29 < 0.29 < hem[:, 0].min()
    front = lying[standing[:, 0] > 0.09]
    back = lying[standing[:, 0] < -0.09]
    assert front[:, 2].min() > back[:, 2].max()
    left = lying[standing[:, 1] > 0.2]
    assert left[:, 1].min() > 0
    assert lying[:, 2].min() == pytest.approx(0.003)


def test_a_garment_whose_front_is_on_the_wrong_axis_is_refused(shirt):
    with pytest.raises(BadInput, match=r"frame\.front"):
        lying_pose(turned(shirt.reshape(-1, 3), 90.0), 0.0, 0.003)
