"""Cloth between closed pads is followed in the tool's frame, from closing to opening."""

import numpy as np
import pytest

from sim1.robot.pad_slip import pad_slip_m

OPENNESS = np.array([0.4, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.4])
SIZE = {"width_m": 0.022, "length_m": 0.06}


def carried(slip_m: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A hand that lifts and turns by a right angle; one vertex between its pads slides along them, one lies on the table."""
    count = len(OPENNESS)
    tools = np.tile(np.eye(4), (count, 2, 1, 1))
    tools[:, 1, :3, 3] = 9.0  # the other hand is far away
    garment = np.zeros((count, 2, 3))
    for t in range(count):
        turn = 0.5 * np.pi * t / (count - 1)
        tools[t, 0, :2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        tools[t, 0, :3, 3] = 0.3, 0.0, 0.02 * t
        held = np.array([-0.02 + slip_m * max(t - 4, 0) / 3, 0.001, 0.0])
        garment[t, 0] = tools[t, 0, :3, :3] @ held + tools[t, 0, :3, 3]
        garment[t, 1] = 0.3, 0.2, 0.0
    return garment, tools, np.stack([OPENNESS, OPENNESS], axis=1)


def test_cloth_that_moves_with_the_hand_does_not_slip():
    assert pad_slip_m(*carried(0.0), **SIZE) == pytest.approx(0.0, abs=1e-12)


def test_a_slip_is_its_way_in_the_tools_frame_and_what_happens_while_the_pads_open_is_none():
    assert pad_slip_m(*carried(0.004), **SIZE) == pytest.approx(0.004)


def test_pads_that_close_on_nothing_have_no_slip():
    garment, tools, openness = carried(0.0)
    assert pad_slip_m(garment[:, 1:], tools, openness, **SIZE) is None
    assert pad_slip_m(garment, tools, np.full_like(openness, 0.4), **SIZE) is None
