"""Plans at the end of the arms' reach, where the fingers are tilted."""

import numpy as np
import pytest
from small_towel import TOWEL

import sim1.robot.demonstrations
from sim1.motion.commands import Arms
from sim1.robot import expert
from sim1.robot.expert import PRESS_M, SPEED_SHARE, TILTS_RAD, TooFast, Workspace, plan_step
from sim1.robot.expert_task import read_task
from sim1.robot.expert_variation import PLAIN
from sim1.robot.stage import SeedDemosConfig, seed_demos
from sim1.scene.description import read_scene
from sim1.stage import BadInput


@pytest.fixture(scope="module")
def arms(inputs):
    return Arms.of_scene(read_scene(inputs["scene"]["towel"]))


@pytest.fixture(scope="module")
def planned(inputs, arms):
    """Function that plans the fold of a small towel so far from the robot."""
    workspace = Workspace.of((arms.arm, arms.arm), read_scene(inputs["scene"]["towel"]))
    task = read_task(inputs["task"]["towel"])

    def plan(x_m: float, variation=PLAIN):
        lying = TOWEL.rest_m + np.array([x_m, 0.0, 0.002])
        return plan_step(workspace, task, 0, lying, lying, workspace.home_rad, variation)

    return plan


def tilt_rad(path) -> np.ndarray:
    """(n, 2) from straight down."""
    return np.arccos(np.clip(-path.rotation[..., 2, 0], -1.0, 1.0))


def lowest_m(path) -> np.ndarray:
    """Height (n, 2) of the lowest corner of the fingers' ends, boxes as in the URDF: 22 mm wide, 10 mm thick outwards."""
    corners = []
    for outwards in (1.0, -1.0):
        for z in (0.011, -0.011):
            y = outwards * (0.044 * path.openness + 0.010)
            corners.append(path.position_m[..., 2] + y * path.rotation[..., 2, 1] + z * path.rotation[..., 2, 2])
    return np.min(corners, axis=0)


@pytest.mark.parametrize("x_m", [0.1, 0.2])
def test_tilted_fingers_press_on_the_cloth_with_their_lowest_edge_open_and_closed(planned, arms, x_m):
    plan = planned(x_m)
    path = arms.tool_path(plan.joints_rad, plan.openness)
    lowest, closed = lowest_m(path), plan.openness[:, 0] < 0.01
    grasping = slice(int(closed.argmax()) - 10, int(closed.argmax()) + 3)  # they close, and wait
    assert (tilt_rad(path)[grasping] > 0.2).all()
    assert np.ptp(path.openness[grasping, 0]) > 0.1
    np.testing.assert_allclose(lowest[grasping], PRESS_M, atol=1e-4)
    assert lowest.min() > PRESS_M - 1e-4


def test_a_tilt_that_reaches_some_points_of_the_way_alone_gives_way_to_the_next_one(planned, arms, monkeypatch):
    tried, solve = [], expert._solve

    def solving(workspace, side, path, tilt, *rest):
        tried.append((side, tilt))
        return solve(workspace, side, path, tilt, *rest)

    monkeypatch.setattr(expert, "_solve", solving)
    plan = planned(0.12)
    first, *_, used = [tilt for side, tilt in tried if side == 0]
    assert used > first
    low = slice(60, 90)  # over the table
    np.testing.assert_allclose(tilt_rad(arms.tool_path(plan.joints_rad, plan.openness))[low, 0], used, atol=0.01)
    assert used in TILTS_RAD


def test_a_plan_that_stays_too_fast_says_so_and_not_that_it_is_out_of_reach(planned, monkeypatch):
    monkeypatch.setattr(expert, "_speed_ratio", lambda *_: 1.0)
    with pytest.raises(TooFast, match=f"100 % of its speed limit, a plan may use {100 * SPEED_SHARE:.0f} %"):
        planned(0.0)


def test_a_garment_that_does_not_come_to_rest_is_named_with_its_mesh_and_scene(inputs, tmp_path, monkeypatch):
    def settle(*_, **__):
        raise BadInput("the garment slid off the table (-0.100 m); check garment.place of the scene")

    monkeypatch.setattr(sim1.robot.demonstrations, "settle", settle)
    with pytest.raises(BadInput) as caught:
        seed_demos(inputs, tmp_path, SeedDemosConfig(substeps=2, iterations=1))
    where = f"{inputs['garment_mesh']['towel']} in {inputs['scene']['towel']}"
    assert str(caught.value).startswith(f"{where}: the garment slid off")
