from dataclasses import replace

import numpy as np
import pytest
from motion_synthetic import HOME, a_demo, a_model, speed_shares
from scipy.spatial.transform import Rotation

from sim1.cloth.cell import SimulationBroke
from sim1.motion import joining
from sim1.motion.assembly import attempt
from sim1.motion.commands import FREE
from sim1.motion.joining import Variation, skeleton
from sim1.motion.model import transition
from sim1.motion.placement import planar
from sim1.motion.poses import ToolPath
from sim1.motion.reaching import changed, reachable
from sim1.motion.replay import compared
from sim1.robot.kinematics import Unreachable
from sim1.robot.session import replay

VARIATION = Variation(radius_m=0.05, angle_rad=0.2, grasp_offset_m=0.0, settle_s=0.2)


class RigidSheet:
    """Stands in for the simulated cell: a sheet that never moves, arms that follow at once."""

    def __init__(self, breaks_at: int | None = None):
        self.breaks_at, self.steps = breaks_at, 0

    def reset(self, garment_m, joints_rad, openness):
        self.garment_m, self.joints_rad, self.openness = np.array(garment_m), joints_rad, openness
        self.steps = 0

    def step(self, joints_rad, openness):
        self.steps += 1
        if self.steps == self.breaks_at:
            raise SimulationBroke(self.steps, 3, "vertex 3 is not finite")
        self.joints_rad, self.openness = joints_rad, openness


def run(demonstrated, arms, seed=0, cell=None, model=None, variation=VARIATION):
    segments, source = demonstrated
    rng = np.random.default_rng(seed)
    return attempt(segments, source, model or a_model(), arms, cell or RigidSheet(), variation, rng, SimulationBroke)


def test_a_skeleton_keeps_the_order_of_the_task_and_mixes_demonstrations():
    rng = np.random.default_rng(0)
    pool = [part for index in range(3) for part in a_demo(f"{index:04d}", rng, 3 * index)]
    drawn = [skeleton(pool, rng) for _ in range(60)]
    assert all([part.order for part in parts] == [0] for parts in drawn)
    assert {parts[0].demo for parts in drawn} == {"0000", "0001", "0002"}


def test_two_step_tasks_keep_their_steps_in_order_and_draw_each_from_any_demonstration():
    rng = np.random.default_rng(0)
    pool = []
    for index in range(3):
        parts = [part for copy in range(2) for part in a_demo(f"{index:04d}", rng, 0)]
        shifts = [0, 0, 0, *[parts[2].end_frame] * 3]
        for part, shift, order in zip(parts, shifts, (0, 0, 0, 1, 1, 1), strict=True):
            frames = {"start_frame": part.start_frame + shift, "end_frame": part.end_frame + shift}
            pool.append(part.__class__(**{**part.__dict__, **frames, "order": order, "segment": len(pool)}))
    drawn = [skeleton(pool, rng) for _ in range(80)]
    assert all([part.order for part in parts] == [0, 1] for parts in drawn)
    assert len({(parts[0].demo, parts[1].demo) for parts in drawn}) == 9


class SheetThatIsPulled(RigidSheet):
    """The sheet comes 4 cm nearer while the grippers close on it for the first time."""

    SHIFT = np.array([-0.04, 0.0, 0.0])

    def reset(self, garment_m, joints_rad, openness):
        super().reset(garment_m, joints_rad, openness)
        self.start_m = self.garment_m

    def step(self, joints_rad, openness):
        super().step(joints_rad, openness)
        if openness.max() < 0.5:
            self.garment_m = self.start_m + self.SHIFT


@pytest.fixture(scope="module")
def in_two_steps(demonstrated):
    """Each demonstration twice over: its second step is the first one again, on a sheet that the first one pulled by 2 cm."""
    segments, source = demonstrated
    pool = []
    for demo in ("0000", "0001"):
        once = [part for part in segments if part.demo == demo]
        for order in (0, 1):
            for part in once:
                shift = order * once[-1].end_frame
                about = {
                    "segment": len(pool),
                    "order": order + part.order,
                    "start_frame": part.start_frame + shift,
                    "end_frame": part.end_frame + shift,
                }
                pool.append(part.__class__(**{**part.__dict__, **about}))
    pulled = 0.5 * SheetThatIsPulled.SHIFT  # less than it is pulled in the attempts
    half = max(part.end_frame for part in pool) // 2
    start = source.home.start_m
    lying = {(part.demo, part.start_frame): start + pulled * (part.start_frame >= half) for part in pool}
    return pool, replace(source, garment_m=lying)


def test_an_attempt_does_both_steps_in_order_and_its_interactions_come_from_any_demonstration(in_two_steps, arms):
    made = [run(in_two_steps, arms, seed=seed) for seed in (2, 5)]
    assert {attempt.failure for attempt in made} == {None}
    assert all([source["order"] for source in attempt.sources] == [0, 1] for attempt in made)
    assert any(len({source["demo"] for source in attempt.sources}) == 2 for attempt in made)
    closings = [np.diff((attempt.episode.command_openness[:, 0] < 0.5).astype(int)) for attempt in made]
    assert [int((closing == 1).sum()) for closing in closings] == [2] * len(made)


def test_the_second_step_follows_the_garment_as_the_first_one_left_it(in_two_steps, arms):
    still = Variation(radius_m=0.0, angle_rad=0.0, grasp_offset_m=0.0, settle_s=0.2)
    made = run(in_two_steps, arms, cell=SheetThatIsPulled(), variation=still)
    tools = arms.tool_path(made.episode.command_joints_rad, made.episode.command_openness)
    closed = np.flatnonzero(np.diff((tools.openness[:, 0] < 0.5).astype(int)) == 1)
    parts = {part.segment: part for part in in_two_steps[0]}
    moved = []
    for frame, source in zip(closed, made.sources, strict=True):
        shown = parts[source["segment"]].path
        first = int(np.flatnonzero(shown.openness[:, 0] < 0.5)[0])
        moved.append(tools.position_m[frame + 1, 0] - shown.position_m[first, 0])
    assert moved[0] == pytest.approx(np.zeros(3), abs=1e-3)
    assert moved[1] == pytest.approx(0.5 * SheetThatIsPulled.SHIFT, abs=1e-3)


def test_failed_demonstrations_are_no_source():
    rng = np.random.default_rng(0)
    pool = a_demo("0000", rng, 0) + a_demo("0001", rng, 3, success=False)
    assert {skeleton(pool, rng)[0].demo for _ in range(30)} == {"0000"}
    with pytest.raises(ValueError, match="no successful"):
        skeleton(a_demo("0001", rng, 0, success=False), rng)


def test_inverse_kinematics_follows_a_path_within_limits(arms, demonstrated):
    path = demonstrated[0][1].path
    joints = arms.joints_for(path, HOME)
    np.testing.assert_allclose(arms.tool_path(joints, path.openness).position_m, path.position_m, atol=2e-4)
    assert (joints >= arms.arm.lower_rad).all()
    assert (joints <= arms.arm.upper_rad).all()


def test_a_pose_out_of_reach_is_refused(arms, demonstrated):
    away = planar(np.array([3.0, 0.0]), 0.0, np.zeros(3))
    with pytest.raises(Unreachable):
        arms.joints_for(demonstrated[0][1].path[:1].moved(away), HOME)


@pytest.mark.parametrize("method", ["minimum_jerk", "slicing"])
def test_an_attempt_runs_from_home_to_home_without_jumps(arms, demonstrated, method):
    made = run(demonstrated, arms, model=a_model(method))
    assert made.failure is None
    episode = made.episode
    assert np.isfinite(episode.command_joints_rad).all()
    assert speed_shares(episode.command_joints_rad, arms).max() <= 1
    np.testing.assert_array_equal(episode.joints_rad[0], HOME)
    if method == "minimum_jerk":
        np.testing.assert_allclose(episode.command_joints_rad[-1], HOME, atol=1e-3)


def test_a_recorded_command_is_what_the_next_state_shows(arms, demonstrated):
    episode = run(demonstrated, arms).episode
    np.testing.assert_array_equal(episode.joints_rad[1:], episode.command_joints_rad[:-1])


def test_grasps_follow_the_garment(arms, demonstrated):
    """The tools take the garment's own placement: seen from the sheet, an interaction is the demonstrated one."""
    made = run(demonstrated, arms, seed=3)
    segments, _ = demonstrated
    part = next(item for item in segments if item.segment == made.sources[0]["segment"])
    wanted = part.path.moved(made.placement).position_m
    tools = arms.tool_path(made.episode.command_joints_rad, made.episode.command_openness).position_m
    errors = [
        np.abs(tools[start : start + len(wanted)] - wanted).max() for start in range(len(tools) - len(wanted) + 1)
    ]
    assert min(errors) < 1e-3
    assert np.abs(made.placement - np.eye(4)).max() > 0.01


@pytest.mark.parametrize("method", ["minimum_jerk", "straight", "slicing"])
def test_a_perturbed_attempt_grasps_beside_the_place(arms, demonstrated, method):
    aside = replace(VARIATION, grasp_offset_m=0.04)
    plain, beside = (run(demonstrated, arms, 3, model=a_model(method), variation=it) for it in (VARIATION, aside))
    assert (plain.failure, beside.failure) == (None, None)
    np.testing.assert_array_equal(plain.placement, beside.placement)
    lows = [arms.tool_path(item.episode.command_joints_rad, item.episode.command_openness) for item in (plain, beside)]
    closed = [path.position_m[path.openness[:, 0].argmin(), 0] for path in lows]
    assert np.linalg.norm(closed[0] - closed[1]) == pytest.approx(0.04, abs=0.002)


def test_the_same_stream_gives_the_same_episode_and_another_one_another(arms, demonstrated):
    one, two, other = (run(demonstrated, arms, seed=seed).episode for seed in (5, 5, 6))
    np.testing.assert_array_equal(one.command_joints_rad, two.command_joints_rad)
    assert len(one.time_s) != len(other.time_s) or not np.array_equal(one.garment_m[0], other.garment_m[0])


def test_a_simulation_that_breaks_is_a_failure_with_the_frames_until_then(arms, demonstrated):
    made = run(demonstrated, arms, cell=RigidSheet(breaks_at=20))
    assert made.failure == "simulation broke"
    assert "vertex 3" in made.detail
    assert made.episode.frame_count == 20


def test_an_attempt_that_broke_is_replayed_to_where_it_broke(arms, demonstrated):
    made = run(demonstrated, arms, cell=RigidSheet(breaks_at=20))
    assert compared("0000", made.episode, replay(RigidSheet(breaks_at=20), made.episode)).same
    sooner = compared("0000", made.episode, replay(RigidSheet(breaks_at=12), made.episode))
    assert sooner.said() == "0000: 12 frames in place of 20"


def test_a_hurried_transition_is_given_the_time_that_the_joints_need(arms, demonstrated, monkeypatch):
    segments, source = demonstrated
    far = np.eye(4)
    far[2, 3] = 0.05
    lifted = [part.__class__(**{**part.__dict__, "path": part.path.moved(far)}) for part in segments]
    ways = []  # all that were tried
    monkeypatch.setattr(joining, "transition", lambda *given: ways.append(transition(*given)) or ways[-1])
    made = run((lifted, source), arms, model=a_model(rest_s=0.05))
    assert made.failure is None
    hurried = arms.joints_for(ways[0][1:-1], HOME, FREE)
    assert speed_shares(hurried, arms).max() > 1.2
    assert len(ways[1]) > len(ways[0])
    fastest = speed_shares(made.episode.command_joints_rad, arms).max()
    assert 0.5 < fastest <= 1
    assert made.speed_share == pytest.approx(fastest)


def test_an_interaction_that_is_too_fast_for_a_joint_is_refused_before_it_runs(arms, demonstrated):
    segments, source = demonstrated
    kept = np.r_[0:6, 22, 39:45]  # it slides out in one frame and back in the next
    hasty = [
        part.__class__(**{**part.__dict__, "path": part.path[kept]}) if part.kind == "interacting" else part
        for part in segments
    ]
    made = run((hasty, source), arms)
    assert made.failure == "too fast"
    assert f"at {made.speed_share:.2f} times its speed limit" in made.detail
    assert made.speed_share > 1.2
    assert speed_shares(made.episode.command_joints_rad, arms).max() <= 1
    assert made.episode.command_openness.min() == 1.0  # it never came to the grasp


class StiffWrists:
    """Arms whose tools cannot turn by more than 0.15 rad from the demonstrated attitude."""

    def __init__(self, shown: ToolPath):
        self.shown = shown

    def joints_for(self, path, start_rad):
        relative = self.shown.rotation.swapaxes(-1, -2) @ path.rotation
        angle = np.arccos(np.clip((np.trace(relative, axis1=-2, axis2=-1) - 1) / 2, -1, 1)).max()
        if angle > 0.15:
            raise Unreachable(0.0, angle)
        return np.zeros((len(path), 2, 6))


def test_the_most_faithful_attitude_in_reach_is_taken_and_fingertips_stay(arms, demonstrated):
    path = demonstrated[0][1].path
    for turn, share in ((0.1, 1.0), (0.2, 0.5), (0.8, 0.0)):
        placement = planar(np.array([0.02, 0.0]), turn, np.zeros(3))
        moved, change, _ = reachable(path, placement, StiffWrists(path), HOME)
        assert change == (share, 0.0)
        np.testing.assert_allclose(moved.position_m, path.moved(placement).position_m, atol=2e-3)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.5, np.pi / 2, -np.pi / 2])
@pytest.mark.parametrize("openness", [0.0, 0.6])
def test_leaning_tilts_the_fingers_forward_whatever_their_yaw_and_keeps_their_lowest_edge_up(arms, yaw_rad, openness):
    down = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    path = ToolPath(
        position_m=np.zeros((1, 2, 3)),
        rotation=np.broadcast_to(Rotation.from_euler("z", yaw_rad).as_matrix() @ down, (1, 2, 3, 3)),
        openness=np.full((1, 2), openness),
    )
    lean = changed(path, np.eye(4), 1.0, 0.3)
    np.testing.assert_allclose(lean.rotation[0, 0, :, 0], [np.sin(0.3), 0, -np.cos(0.3)], atol=1e-12)
    assert lowest_corner_m(lean) == pytest.approx(lowest_corner_m(path), abs=1e-12)
    assert lean.position_m[0, 0, 2] > 0.0


def lowest_corner_m(path) -> float:
    """Height of the lowest corner of the ends of both fingers, boxes as in the URDF: 22 mm wide along z, 10 mm thick outwards along y."""
    travel = 0.044 * path.openness[0, 0]
    ends = [[0.0, y, z] for y in (travel + 0.01, -travel - 0.01) for z in (0.011, -0.011)]
    return float((path.position_m[0, 0] + np.array(ends) @ path.rotation[0, 0].T)[:, 2].min())
