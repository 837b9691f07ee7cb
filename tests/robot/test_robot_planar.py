from pathlib import Path

import numpy as np
import pytest

from sim1.robot.kinematics import Arm, Unreachable
from sim1.robot.planar import PlanarArm

ARM = Arm.from_urdf(Path(__file__).parents[2] / "data" / "robot" / "robot.urdf")
PLANAR = PlanarArm.of(ARM)


@pytest.mark.parametrize("tilt", [0.0, 0.3, 0.8])
def test_postures_put_the_tool_at_the_points_with_the_asked_tilt(tilt):
    points = np.random.default_rng(1).uniform([0, -0.6, -0.2], [0.8, 0.6, 0.3], (500, 3))
    q = PLANAR.postures(points, tilt)
    reached = np.isfinite(q).all(axis=1)
    assert 0.2 < reached.mean() < 0.9
    tools = ARM.forward(q[reached])
    np.testing.assert_allclose(tools[:, :3, 3], points[reached], atol=1e-9)
    np.testing.assert_allclose(tools[:, 2, 0], -np.cos(tilt), atol=1e-9)


def test_the_search_finds_nothing_where_the_closed_form_says_out_of_reach():
    points = np.array([[x, 0.001, -0.15] for x in (0.3, 0.45, 0.53, 0.56, 0.65)])
    closed = np.isfinite(PLANAR.postures(points, 0.0)[:, 0])
    assert closed.tolist() == [True, True, True, False, False]
    down = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])
    for point, reachable in zip(points, closed, strict=True):
        target = np.eye(4)
        target[:3, :3], target[:3, 3] = down, point
        if reachable:
            ARM.inverse(target, np.array([0, 1.5, 1.5, -1.5, 0, 0]))
        else:
            with pytest.raises(Unreachable):
                ARM.inverse(target, np.array([0, 1.5, 1.5, -1.5, 0, 0]), restart_count=3)


def test_nothing_is_reached_beyond_the_stretched_arm():
    points = np.random.default_rng(2).normal(0, 0.6, (2000, 3))
    too_far = (
        np.linalg.norm(points - [0, 0, PLANAR.shoulder[1]], axis=1) > PLANAR.stretched_m + PLANAR.shoulder[0] + 0.001
    )
    assert too_far.sum() > 100
    for tilt in (0.0, 0.7, 1.4):
        assert np.isnan(PLANAR.postures(points[too_far], tilt)).all()
