from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sim1.robot.kinematics import Arm, Unreachable

URDF = Path(__file__).parents[2] / "data" / "robot" / "robot.urdf"
ARM = Arm.from_urdf(URDF)
HOME = np.array([0.0, 0.6, 0.6, -0.9, 0.0, 0.0])


def inside(share: float = 1.0):
    """Joint angles within the given share of the range."""
    middle, half = (ARM.lower_rad + ARM.upper_rad) / 2, share * (ARM.upper_rad - ARM.lower_rad) / 2
    bounds = zip(middle - half, middle + half, strict=True)
    return st.tuples(*(st.floats(low, high) for low, high in bounds)).map(np.array)


def test_arm_is_folded_at_zero():
    poses = ARM.link_poses(np.zeros(6))
    np.testing.assert_allclose(poses["link3"][:3, 3], [-0.244, 0, 0.1005], atol=1e-9)  # elbow: backward of the shoulder
    np.testing.assert_allclose(poses["link4"][:3, 3], [0.001, 0, 0.1565], atol=1e-9)  # wrist: forward again, above
    np.testing.assert_allclose(poses["tool"][:3, 3], [0.2402, 0.001, 0.1565], atol=1e-9)
    np.testing.assert_allclose(poses["tool"][:3, :3], np.eye(3), atol=1e-9)


def test_raising_shoulder_and_elbow_lifts_the_arm_and_stretches_it_forward():
    tips = ARM.forward(np.outer(np.linspace(0, 0.9, 10), [0, 1, 1, 0, 0, 0]))[:, :3, 3]
    assert (np.diff(tips[:, 2]) > 0).all()
    assert (np.diff(tips[:, 0]) > 0).all()
    level = ARM.forward([0, 0.8, 0.8, 0, 0, 0])[:3, 0]
    np.testing.assert_allclose(level, [1, 0, 0], atol=1e-9)  # equal angles keep the forearm level


def test_published_offsets_and_limits_are_those_of_the_urdf():
    offsets = [joint.origin[:3, 3].tolist() for joint in ARM.joints]
    assert offsets == [
        [0, 0, 0.0603],
        [0.02, 0, 0.0402],
        [-0.264, 0, 0],
        [0.245, 0, -0.056],
        [0.06575, -0.001, -0.0825],
        [0.02845, 0, 0.0825],
    ]
    assert ARM.chain[-1].origin[:3, 3].tolist() == [0.145, 0, 0]
    assert ARM.lower_rad[1:].tolist() == [0, 0, -1.571, -1.67, -1.57]
    assert ARM.upper_rad[1:].tolist() == [3.14, 3.14, 1.571, 1.67, 1.57]


def test_link_poses_agree_with_newtons_own_import_of_the_urdf():
    import newton
    import warp as wp

    builder = newton.ModelBuilder()
    builder.add_urdf(str(URDF))
    model = builder.finalize(device="cpu")
    state = model.state()
    stream = np.random.default_rng(3)
    for q in [np.zeros(6), *stream.uniform(ARM.lower_rad, ARM.upper_rad, (5, 6))]:
        joint_q = wp.array(np.array([*q, 0.01, 0.01], np.float32), dtype=float, device="cpu")
        newton.eval_fk(model, joint_q, model.joint_qd, state)
        ours = ARM.link_poses(q, travel_m=0.01)
        for label, body in zip(model.body_label, state.body_q.numpy(), strict=True):
            pose = ours[label.rpartition("/")[2]]
            np.testing.assert_allclose(body[:3], pose[:3, 3], atol=1e-6, err_msg=label)
            np.testing.assert_allclose(Rotation.from_quat(body[3:]).as_matrix(), pose[:3, :3], atol=1e-6, err_msg=label)
    limits = model.joint_limit_lower.numpy()[:6], model.joint_limit_upper.numpy()[:6]
    np.testing.assert_allclose(limits, [ARM.lower_rad, ARM.upper_rad], atol=1e-6)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(inside())
def test_jacobian_is_the_derivative_of_the_tool_pose(q):
    step = 1e-6
    jacobian = ARM.jacobian(q)
    for joint in range(6):
        ahead, behind = (ARM.forward(q + sign * step * np.eye(6)[joint]) for sign in (1, -1))
        velocity = (ahead[:3, 3] - behind[:3, 3]) / (2 * step)
        turning = Rotation.from_matrix(ahead[:3, :3] @ behind[:3, :3].T).as_rotvec() / (2 * step)
        np.testing.assert_allclose(jacobian[:, joint], [*velocity, *turning], atol=1e-6)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(inside(0.95))
def test_inverse_finds_angles_within_limits_for_every_pose_that_the_arm_can_take(q):
    target = ARM.forward(q)
    found = ARM.inverse(target, HOME)
    assert (found >= ARM.lower_rad).all()
    assert (found <= ARM.upper_rad).all()
    np.testing.assert_allclose(ARM.forward(found)[:3, 3], target[:3, 3], atol=1e-4)
    assert Rotation.from_matrix(ARM.forward(found)[:3, :3].T @ target[:3, :3]).magnitude() < 1e-3


@settings(max_examples=25, deadline=None, derandomize=True)
@given(inside(0.8))
def test_inverse_stays_on_the_branch_of_a_nearby_start(q):
    found = ARM.inverse(ARM.forward(q), q + 0.02)
    jacobian = ARM.jacobian(q)
    if np.linalg.svd(jacobian, compute_uv=False)[-1] > 0.02:  # away from singular postures, where branches meet
        np.testing.assert_allclose(found, q, atol=0.02)


def test_a_pose_out_of_reach_is_refused_with_how_far_off_it_is():
    target = ARM.forward(HOME)
    target[:3, 3] = [1.5, 0, 0.2]
    with pytest.raises(Unreachable, match=r"mm and .* degrees away") as caught:
        ARM.inverse(target, HOME)
    assert 0.6 < caught.value.position_error_m < 1.0  # the stretched arm ends 0.77 m from the base


def test_forward_takes_any_leading_axes():
    q = np.random.default_rng(0).uniform(ARM.lower_rad, ARM.upper_rad, (3, 4, 6))
    tools = ARM.forward(q)
    assert tools.shape == (3, 4, 4, 4)
    np.testing.assert_allclose(tools[2, 1], ARM.link_poses(q[2, 1])["tool"], atol=1e-12)


def test_fingers_open_along_the_tools_y_axis_and_meet_at_its_origin():
    closed, opened = (ARM.link_poses(HOME, travel) for travel in (0.0, 0.044))
    tool = np.linalg.inv(opened["tool"])
    for name, side in (("finger_1", 1), ("finger_2", -1)):
        moved = tool[:3, :3] @ (opened[name][:3, 3] - closed[name][:3, 3])
        np.testing.assert_allclose(moved, [0, side * 0.044, 0], atol=1e-9)
        shape = ARM.robot.links[name].collisions[0]
        tip = (tool @ closed[name])[0, 3] + shape.origin[0, 3] + shape.size_m[0] / 2
        assert tip == pytest.approx(0.0, abs=1e-9)  # the pads end at the tool's origin
