"""A plan is measured by where its joints have the tools, not by where these were wanted."""

from dataclasses import replace

import numpy as np
from motion_synthetic import HOME, a_model

from sim1.motion import joining
from sim1.motion.commands import FREE, HANDLING
from sim1.motion.joining import Draw, Laid
from sim1.motion.planning import planned

ROLL = 5  # the last joint


def test_a_way_that_a_joint_at_its_limit_passes_beside_is_on_the_sheet_as_it_is_passed(
    reached, home, arms, monkeypatch
):
    bow = np.sin(np.linspace(0, np.pi, 41))
    joints = np.repeat(HOME[None], len(bow), axis=0)
    limit = arms.arm.upper_rad[ROLL]
    joints[:, 0, ROLL] = limit - 0.05 + 0.15 * bow
    wanted = arms.tool_path(joints, np.ones((len(bow), 2)))
    monkeypatch.setattr(joining, "transition", lambda *_: wanted)
    draw = Draw(picked=reached[1:2], placement=np.eye(4), offset=np.eye(4))
    still = Laid(placement=np.eye(4), path=wanted[np.zeros(10, int)])
    there = replace(home, joints_rad=joints[0])
    plan = planned(reached, there, draw, lambda _: still, a_model(), arms, 0.2, lambda: np.random.default_rng(0))

    assert plan.joints_rad.max(axis=(0, 1))[ROLL] <= limit
    tools = arms.tool_path(plan.joints_rad, plan.path.openness)
    np.testing.assert_array_equal(plan.path.position_m, tools.position_m)
    np.testing.assert_array_equal(plan.path.rotation, tools.rotation)
    beside = np.abs(plan.path.rotation[: len(bow) - 2] - wanted.rotation[1:-1]).max()
    assert HANDLING.rotation_rad < beside < FREE.rotation_rad
    assert len(plan.path) == len(plan.joints_rad) == plan.spans[-1].end
