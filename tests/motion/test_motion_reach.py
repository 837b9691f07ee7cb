"""At a joint's limit: a way with open fingers passes beside its poses, a grip keeps to them."""

import numpy as np
import pytest
from motion_synthetic import HOME, a_model

from sim1.motion import joining
from sim1.motion.commands import FREE, HANDLING
from sim1.motion.joining import Follower
from sim1.robot.kinematics import Unreachable

ROLL = 5  # the last joint
OPEN = np.ones(2)


def past_the_limit(arms, excess_rad):
    """A tool path on which the left arm's last joint would pass its limit by so much and come back, and its first joints."""
    bow = np.sin(np.linspace(0, np.pi, 41))
    joints = np.repeat(HOME[None], len(bow), axis=0)
    limit = arms.arm.upper_rad[ROLL]
    joints[:, 0, ROLL] = limit - 0.05 + (0.05 + excess_rad) * bow
    return arms.tool_path(joints, np.ones((len(bow), 2))), joints[0]


@pytest.mark.parametrize(("excess_rad", "free", "handling"), [(0.01, True, True), (0.1, True, False), (1.2, False, False)])  # fmt: skip
def test_a_pose_beyond_a_limit_is_passed_as_near_as_the_tolerance_allows(arms, excess_rad, free, handling):
    path, start = past_the_limit(arms, excess_rad)
    for tolerance, followed in ((FREE, free), (HANDLING, handling)):
        if not followed:
            with pytest.raises(Unreachable):
                arms.joints_for(path, start, tolerance)
            continue
        joints = arms.joints_for(path, start, tolerance)
        assert (joints <= arms.arm.upper_rad).all()
        tools = arms.tool_path(joints, path.openness)
        np.testing.assert_allclose(tools.position_m, path.position_m, atol=tolerance.position_m)
        np.testing.assert_allclose(tools.position_m[[0, -1]], path.position_m[[0, -1]], atol=1e-6)  # ends are in reach
        assert np.abs(np.diff(joints, axis=0)).max() < 0.1  # no jump to another posture


class Notes:
    def __init__(self):
        self.ran = []

    def run(self, joints_rad, path, kind):
        self.ran.append((kind, len(joints_rad)))


def test_a_way_between_interactions_may_and_an_interaction_may_not(arms, monkeypatch):
    path, start = past_the_limit(arms, 0.1)
    monkeypatch.setattr(joining, "transition", lambda *_: path)
    taker = Notes()
    follower = Follower(arms, taker, start, OPEN)
    follower.go(a_model("minimum_jerk"), path[-1:], None, np.random.default_rng(0))
    assert taker.ran == [("moving", len(path) - 2)]
    with pytest.raises(Unreachable):
        Follower(arms, taker, start, OPEN).follow(path, "interacting")
