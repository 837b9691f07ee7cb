"""What becomes of an attempt: the judge looks at its garment as if it had lain at home, and the head camera must have seen it."""

from types import SimpleNamespace

import numpy as np
import pytest
from motion_synthetic import HOME, a_model

from sim1.cloth.garment import grid_towel
from sim1.episode import RATE_HZ, Episode
from sim1.motion.assembly import Attempt, Source
from sim1.motion.bench import Bench
from sim1.motion.home import Home
from sim1.motion.placement import planar, unplaced
from sim1.motion.stage import CandidateTrajectoriesConfig
from sim1.robot.expert_task import read_task
from sim1.scene.description import Camera
from sim1.validity.success import judge

TASK = """
schema: sim1.task/1
title: Fold in half
keypoints: {near_left: [-1.0, 1.0], near_right: [-1.0, -1.0]}
steps:
  - name: near edge onto far edge
    left: {grasp: near_left, fold: {axis: x, at: 0.5}}
    right: {grasp: near_right, fold: {axis: x, at: 0.5}}
"""
SHEET = grid_towel(0.30, 0.24, 0.03)
FRAMES = 40
MIDDLE_M = np.array([0.05, 0.02, 0.0])  # beside the origin: turning and then moving is not moving and then turning
LAID = planar(np.array([0.06, -0.04]), 0.5, MIDDLE_M)
HALF_WIDTH_M = 0.5  # of what the camera sees of the table


def folding() -> np.ndarray:
    """(T, v, 3): at home, the near half is turned over onto the far one and rests there for half of the time."""
    near = SHEET.rest_m[:, 0] < 0
    motion = np.repeat(SHEET.rest_m[None], FRAMES, axis=0)
    angle = np.pi * np.clip(2 * np.linspace(0, 1, FRAMES), 0, 1)[:, None]
    motion[:, near, 0] = SHEET.rest_m[near, 0] * np.cos(angle)
    motion[:, near, 2] = -SHEET.rest_m[near, 0] * np.sin(angle) + 0.002  # one layer above the other
    motion[0] = SHEET.rest_m
    return motion + MIDDLE_M


def still() -> np.ndarray:
    return np.repeat(folding()[:1], FRAMES, axis=0)


def moved(garment_m: np.ndarray, placement: np.ndarray) -> np.ndarray:
    return garment_m @ placement[:3, :3].T + placement[:3, 3]


def aside(beyond_m: float) -> np.ndarray:
    """Placement by which the far edge of the sheet lies so far beyond the picture's edge."""
    edge_m = folding()[0, :, 0].max()
    return planar(np.array([HALF_WIDTH_M + beyond_m - edge_m, 0.0]), 0.0, np.zeros(3))


def attempt_of(garment_m: np.ndarray, failure: str | None = None) -> Attempt:
    arms, opened = np.repeat(HOME[None], FRAMES, axis=0), np.ones((FRAMES, 2))
    episode = Episode(
        time_s=np.arange(FRAMES) / RATE_HZ,
        joints_rad=arms,
        openness=opened,
        command_joints_rad=arms,
        command_openness=opened,
        garment_m=garment_m.astype(np.float32),
    )
    return Attempt(episode=episode, sources=[], failure=failure, detail="", placement=np.eye(4), speed_share=0.5)


@pytest.fixture
def task(tmp_path):
    (tmp_path / "task.yaml").write_text(TASK)
    return read_task(tmp_path / "task.yaml")


@pytest.fixture
def bench(task, arms) -> Bench:
    """Demonstrations began at home, under a camera so far above that what is lifted hardly looks larger."""
    above = np.eye(4)
    above[2, 3] = 20.0
    camera = Camera(width=640, height=480, fy_px=320 * 20.0 / HALF_WIDTH_M, pose=above)
    home = Home(start_m=folding()[0], joints_rad=HOME, openness=np.ones(2), first_openness=np.ones(2))
    return Bench(
        garment="sheet",
        mesh=SHEET,
        scene=SimpleNamespace(cameras={"head": camera}),
        task=task,
        pool=[],
        model=a_model(),
        source=Source(home=home, garment_m={}),
        arms=arms,
        cell=None,
        config=CandidateTrajectoriesConfig(),
    )


@pytest.mark.parametrize("turn_rad", [-0.6, 0.0, 0.5, 2.5])
def test_a_garment_that_was_laid_down_elsewhere_is_seen_as_if_it_lay_at_home(turn_rad):
    there = moved(folding(), planar(np.array([0.06, -0.04]), turn_rad, MIDDLE_M))
    np.testing.assert_allclose(unplaced(there, folding()[0]), folding(), atol=1e-9)


def test_a_fold_of_a_garment_that_was_laid_down_elsewhere_succeeds_with_the_figures_that_it_would_have_at_home(bench):
    there = moved(folding(), LAID)
    assert not judge(there, SHEET.faces, bench.task).success  # its fold lines lie along the table's axes
    success, failure, figures = bench._judged(attempt_of(there))
    assert (success, failure) == (True, None)
    at_home = judge(folding(), SHEET.faces, bench.task).figures
    assert figures == pytest.approx({**at_home, "in_view_share": 1.0}, abs=0.02)  # a row of pixels more or less
    assert figures["iou"] > 0.9
    assert figures["keypoint_error_m"] < 0.01


@pytest.mark.parametrize("beyond_m", [0.01, 0.4])  # the column of vertices at its edge, or all of it
def test_a_fold_that_the_head_camera_did_not_see_whole_is_out_of_view(bench, beyond_m):
    there = moved(folding(), aside(beyond_m))
    success, failure, figures = bench._judged(attempt_of(there))
    assert (success, failure) == (False, "out of view")
    assert figures["in_view_share"] == pytest.approx((there[..., 0] < HALF_WIDTH_M).mean(axis=1).min())
    assert figures["iou"] > 0.9  # it was folded, nevertheless
    assert bench._judged(attempt_of(moved(folding(), aside(-0.01))))[:2] == (True, None)


def test_a_sheet_that_never_moved_is_a_missed_grasp_in_view_and_out_of_it(bench):
    for placement, share in ((LAID, 1.0), (aside(0.4), 0.0)):
        success, failure, figures = bench._judged(attempt_of(moved(still(), placement)))
        assert (success, failure) == (False, "missed grasp")
        assert figures["lifted_m"] == pytest.approx(0.0, abs=1e-6)
        assert figures["in_view_share"] == share


def test_an_attempt_that_was_not_carried_out_keeps_its_class_however_well_the_garment_lies(bench):
    assert bench._judged(attempt_of(folding(), failure="too fast")) == (False, "too fast", {})
