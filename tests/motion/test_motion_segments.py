from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim1.episode import RATE_HZ
from sim1.motion.segments import SegmentationConfig, Span, cut, grasp_vertices, interacting_frames

CONFIG = SegmentationConfig(
    change_rate_per_s=0.25, hold_below=0.35, release_above=0.45, contact_m=0.02, margin_s=0.1, minimum_s=0.3
)
MINIMUM = round(CONFIG.minimum_s * RATE_HZ)


@given(st.lists(st.booleans(), min_size=1, max_size=200))
def test_spans_cover_every_frame_once_and_alternate(flags):
    spans = cut(np.array(flags), CONFIG)
    assert spans[0].start == 0
    assert spans[-1].end == len(flags)
    for before, after in pairwise(spans):
        assert before.end == after.start
        assert before.kind != after.kind
    assert all(span.end - span.start >= MINIMUM for span in spans[1:-1])


@pytest.mark.parametrize("count", [0, 1, 4, 9])
def test_any_number_of_interactions_is_found(count):
    active = np.zeros(60 * count + 30, bool)
    for index in range(count):
        active[60 * index + 30 : 60 * index + 50] = True
    spans = cut(active, CONFIG)
    assert sum(span.kind == "interacting" for span in spans) == count
    if count:
        margin = round(CONFIG.margin_s * RATE_HZ)
        assert spans[1] == Span(kind="interacting", start=30 - margin, end=50 + margin)


def a_grasp(contact: bool):
    """The left gripper closes at frame 30, holds until 80, and opens; the right one does nothing."""
    time = np.arange(120)
    left = np.interp(time, [0, 30, 36, 80, 86], [1, 1, 0.1, 0.1, 1])
    openness = np.stack([left, np.ones(120)], axis=1)
    tool = np.zeros((120, 2, 3))
    tool[:, 1] = [0, -0.5, 0.3]
    garment = np.array([[0.3, 0.0, 0.0], [0.005 if contact else 0.2, 0.0, 0.0], [0.2, 0.2, 0.0]])
    return openness, tool, np.repeat(garment[None], 120, axis=0)


def test_closing_on_cloth_interacts_until_release():
    active = interacting_frames(*a_grasp(contact=True), CONFIG)
    assert active[31:85, 0].all()
    assert not active[:28, 0].any()
    assert not active[90:, 0].any()
    assert not active[:, 1].any()


def test_a_gripper_that_closes_far_from_the_cloth_moves_and_does_not_interact():
    assert not interacting_frames(*a_grasp(contact=False), CONFIG).any()


def test_a_slow_drift_of_the_gripper_is_no_interaction():
    openness, tool, garment = a_grasp(contact=True)
    openness[:, 0] = np.linspace(1.0, 0.5, 120)  # at the cloth, 0.13 per second
    assert not interacting_frames(openness, tool, garment, CONFIG).any()


def test_the_grasp_point_is_the_vertex_at_the_finger_tips():
    openness, tool, garment = a_grasp(contact=True)
    span = Span(kind="interacting", start=25, end=95)
    assert grasp_vertices(span, openness, tool, garment, CONFIG) == (1, -1)


def test_each_step_of_a_task_becomes_an_interaction_with_its_own_grasp():
    """Between the steps the gripper opens wide on its way home and half for the next grasp: that touches nothing."""
    time = np.arange(240)
    turns = [0, 30, 36, 80, 86, 100, 110, 128, 132, 150, 156, 200, 206]
    left = np.interp(time, turns, [0.5, 0.5, 0.0, 0.0, 0.4, 0.4, 1.0, 1.0, 0.8, 0.8, 0.0, 0.0, 0.4])
    openness = np.stack([left, np.ones(240)], axis=1)
    tool = np.zeros((240, 2, 3))
    tool[:, 0, 2] = np.interp(time, [90, 100, 135, 145], [0.0, 0.2, 0.2, 0.0])
    tool[140:, 0, 0] = 0.3
    tool[:, 1] = [0, -0.5, 0.3]
    garment = np.repeat(np.array([[0.305, 0.0, 0.0], [0.005, 0.0, 0.0], [0.2, 0.2, 0.0]])[None], 240, axis=0)
    interactions = [
        span
        for span in cut(interacting_frames(openness, tool, garment, CONFIG).any(axis=1), CONFIG)
        if span.kind == "interacting"
    ]
    assert [grasp_vertices(span, openness, tool, garment, CONFIG) for span in interactions] == [(1, -1), (0, -1)]
    assert interactions[0].end < 110
    assert interactions[1].start > 135


def test_a_flickering_gripper_does_not_end_a_grasp():
    openness, tool, garment = a_grasp(contact=True)
    openness[50:60, 0] += 0.3 * (np.arange(10) % 2)  # up to 0.4, between the two thresholds
    assert interacting_frames(openness, tool, garment, CONFIG)[45:75, 0].all()
