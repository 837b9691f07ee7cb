from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim1.robot.gripper import (
    FINGER_TRAVEL_M,
    angle_from_openness,
    openness_from_angle,
)
from sim1.robot.urdf import read_urdf

URDF = Path(__file__).parents[2] / "data" / "robot" / "robot.urdf"


def test_openness_follows_the_papers_equation():
    angles = np.array([0.5, 0.0, -1.62, -3.24, -4.0])
    assert openness_from_angle(angles).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]
    assert not np.signbit(openness_from_angle(angles)).any()


@given(st.floats(0, 1))
def test_openness_survives_the_way_through_the_angle(openness):
    assert openness_from_angle(angle_from_openness(openness)) == pytest.approx(openness, abs=1e-12)


def test_travel_is_the_range_of_the_urdfs_finger_joints():
    limits = [joint.upper for joint in read_urdf(URDF).joints.values() if joint.kind == "prismatic"]
    assert limits == [FINGER_TRAVEL_M, FINGER_TRAVEL_M]
