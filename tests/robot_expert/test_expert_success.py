from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from sim1.cloth.garment import grid_towel
from sim1.robot.expert_task import find_keypoints, ideal_fold, read_task
from sim1.stage import BadInput
from sim1.validity.success import judge

TASK = """
schema: sim1.task/1
title: Fold in half
keypoints: {near_left: [-1.0, 1.0], near_right: [-1.0, -1.0]}
steps:
  - name: over
    left: {grasp: near_left, fold: {axis: x, at: 0.5}}
    right: {grasp: near_right, fold: {axis: x, at: 0.5}}
"""
TWO_STEPS = """
schema: sim1.task/1
title: Sides in, then in half
keypoints: {left: [-0.1, 1.0], right: [-0.1, -1.0], near_left: [-1.0, 0.1], near_right: [-1.0, -0.1]}
steps:
  - name: sides in
    left: {grasp: left, fold: {axis: y, at: 0.75}}
    right: {grasp: right, fold: {axis: y, at: 0.25}}
  - name: over
    left: {grasp: near_left, fold: {axis: x, at: 0.5}}
    right: {grasp: near_right, fold: {axis: x, at: 0.5}}
"""
TOWEL = grid_towel(0.30, 0.40, 0.025)
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.fixture
def task(tmp_path):
    path = tmp_path / "task.yaml"
    path.write_text(TASK)
    return read_task(path)


def lying(height: float = 0.002) -> np.ndarray:
    return TOWEL.rest_m + np.array([0, 0, height])


def folded(task) -> np.ndarray:
    end = lying()
    end[:, :2] = ideal_fold(lying(), task)
    return end


def run_to(*stages: np.ndarray, frames: int = 20) -> np.ndarray:
    """A garment trajectory that goes evenly through these states and rests at the last."""
    parts = [np.linspace(a, b, frames) for a, b in pairwise(stages)]
    return np.concatenate([*parts, np.repeat(stages[-1][None], 15, axis=0)]).astype(np.float32)


def lifted(state: np.ndarray, by: float) -> np.ndarray:
    """Like paper bent up: the near half rises, lengths hardly change at the small angles used here."""
    up = state.copy()
    up[:, 2] += by
    return up


def test_keypoints_are_the_corners_they_are_named_after(task):
    marks = find_keypoints(lying(), task)
    assert lying()[marks["near_left"], :2] == pytest.approx([-0.15, 0.2])
    assert lying()[marks["near_right"], :2] == pytest.approx([-0.15, -0.2])


def test_ideal_fold_mirrors_the_near_half_and_leaves_the_far_one(task):
    flat = ideal_fold(lying(), task)
    assert flat[:, 0] == pytest.approx(np.abs(TOWEL.rest_m[:, 0]))
    assert flat[:, 1] == pytest.approx(TOWEL.rest_m[:, 1])


def test_an_ideal_fold_succeeds(task):
    outcome = judge(run_to(lying(), lifted(lying(), 0.1), lifted(folded(task), 0.1), folded(task)), TOWEL.faces, task)
    assert (outcome.success, outcome.failure) == (True, None)
    assert outcome.figures["iou"] > 0.97
    assert outcome.figures["area_ratio"] == pytest.approx(0.5, abs=0.02)


def test_doing_nothing_is_a_missed_grasp(task):
    outcome = judge(run_to(lying(), lying()), TOWEL.faces, task)
    assert (outcome.success, outcome.failure) == (False, "missed grasp")


def test_dropping_the_edge_half_way_is_a_slip(task):
    outcome = judge(run_to(lying(), lifted(lying(), 0.1), lying()), TOWEL.faces, task)
    assert outcome.failure == "slip"


def test_a_stretched_garment_is_told(task):
    wide = lying() * [1.8, 1.0, 1.0]
    assert judge(run_to(lying(), wide), TOWEL.faces, task).failure == "over-stretch"


def test_a_garment_beside_the_table_is_told(task):
    assert judge(run_to(lying(), lifted(lying(), -0.3)), TOWEL.faces, task).failure == "off the table"


def test_a_fold_that_ends_in_the_wrong_place_is_not_folded(task):
    aside = folded(task) + np.array([0.0, 0.15, 0.0])
    outcome = judge(run_to(lying(), lifted(lying(), 0.1), lifted(aside, 0.1), aside), TOWEL.faces, task)
    assert outcome.failure == "not folded"
    assert outcome.figures["keypoint_error_m"] == pytest.approx(0.15, abs=0.01)


def test_a_towel_turned_over_is_told_from_one_pushed_to_the_same_place(task):
    flip = replace(
        task, success=replace(task.success, face_down_share=0.9, area_excess=0.6, iou=0.4, keypoint_error_m=0.2)
    )
    pushed = lying() + np.array([0.1, 0, 0])
    turned = pushed * [-1, 1, 1] + np.array([0.2, 0, 0])
    right = judge(run_to(lying(), lifted(lying(), 0.1), lifted(turned, 0.1), turned), TOWEL.faces, flip)
    wrong = judge(run_to(lying(), lifted(lying(), 0.1), lifted(pushed, 0.1), pushed), TOWEL.faces, flip)
    assert (right.figures["face_down_share"], wrong.figures["face_down_share"]) == pytest.approx((1.0, 0.0))
    assert (right.failure, wrong.success) == (None, False)


@pytest.fixture
def two_steps(tmp_path):
    """The left and right quarter in, then the near half of what lies there over."""
    path = tmp_path / "two.yaml"
    path.write_text(TWO_STEPS)
    return read_task(path)


def test_ideal_folds_of_several_steps_follow_each_other(two_steps):
    x, y = TOWEL.rest_m[:, 0], TOWEL.rest_m[:, 1]
    narrow = np.where(np.abs(y) > 0.1, np.sign(y) * (0.2 - np.abs(y)), y)
    assert ideal_fold(lying(), two_steps, 1) == pytest.approx(np.column_stack([x, narrow]))
    assert ideal_fold(lying(), two_steps) == pytest.approx(np.column_stack([np.abs(x), narrow]))


def test_a_task_of_two_steps_is_judged_where_the_last_one_ends(two_steps):
    states = [lying()]
    for count in (1, 2):
        flat = np.column_stack([ideal_fold(lying(), two_steps, count), lying()[:, 2]])
        states += [lifted(states[-1], 0.1), lifted(flat, 0.1), flat]
    whole = judge(run_to(*states), TOWEL.faces, two_steps)
    first_alone = judge(run_to(*states[:4]), TOWEL.faces, two_steps)
    assert (whole.success, whole.failure) == (True, None)
    assert whole.figures["area_ratio"] == pytest.approx(0.25, abs=0.03)
    assert not first_alone.success
    assert first_alone.figures["keypoint_error_m"] == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize("frame", [0, 25, -1])
def test_a_garment_that_is_no_number_anywhere_is_a_broken_simulation(task, frame):
    run = run_to(lying(), lifted(lying(), 0.1), folded(task))
    run[frame, 7, 2] = np.nan
    outcome = judge(run, TOWEL.faces, task)
    assert (outcome.success, outcome.failure, outcome.figures) == (False, "simulation broke", {})


def test_a_layer_that_went_through_the_other_is_a_penetration(task):
    through = folded(task)
    over = lying()[:, 0] < 0
    through[over, 2] = 0.004
    dent = np.argmin(np.linalg.norm(through[:, :2] - [0.1, 0.1], axis=1) + ~over)
    through[dent, 2] = 0.001  # one vertex of the upper layer below the lower one at 0.002
    through[over, :2] += [0.003, 0.004]  # else edges would meet edges
    outcome = judge(run_to(lying(), lifted(lying(), 0.1), lifted(through, 0.1), through), TOWEL.faces, task)
    assert outcome.failure == "penetration"
    assert outcome.figures["crossing_count"] >= 3


def test_a_garment_still_moving_at_the_end_is_not_folded(task):
    moving = run_to(lying(), lifted(lying(), 0.1), lifted(folded(task), 0.1), folded(task))
    moving[-10:, :, 2] += np.linspace(0, 0.05, 10)[:, None]
    assert judge(moving, TOWEL.faces, task).failure == "not folded"


def test_the_shipped_garments_are_folded_in_one_step_but_for_the_shirt_whose_sleeves_come_first():
    tasks = {path.stem: read_task(path) for path in (EXAMPLES.parents[1] / "data" / "tasks").glob("*.yaml")}
    assert {name: len(task.steps) for name, task in tasks.items()} == {"towel": 1, "shorts": 1, "polo": 1, "tshirt": 2}
    assert [step.left.grasp for step in tasks["tshirt"].steps] == ["sleeve_left", "neck_left"]


def test_a_task_that_says_nothing_in_words_is_to_fold_the_garment(task):
    assert task.instruction("polo") == "fold the polo"


def test_a_task_is_told_in_its_own_words():
    flip = read_task(EXAMPLES / "towel_flip.yaml")
    assert flip.instruction("towel") == "turn the towel over"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("sim1.task/1", "sim1.task/9", "schema"),
        ("grasp: near_left", "grasp: nowhere", "nowhere"),
        ("axis: x, at: 0.5", "axis: z, at: 0.5", "axis"),
        ("axis: x, at: 0.5", "axis: x, at: 1.5", "at"),
        ("title:", "tittle:", "tittle"),
        ("title:", "text: 3\ntitle:", "text is 3"),
        ("title:", "text: ''\ntitle:", "text is ''"),
        ("title:", 'text: "two\\nlines"\ntitle:', "text is 'two"),
        ("[-1.0, 1.0]", "[0.0, 0.0]", "no length"),
        ("steps:", "steps: [", "readable"),
    ],
)
def test_a_damaged_task_file_is_refused(tmp_path, old, new, complaint):
    path = tmp_path / "task.yaml"
    path.write_text(TASK.replace(old, new))
    with pytest.raises(BadInput, match=complaint):
        read_task(path)
