"""Where a drive is between its samples."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim1.cloth.precise.drives import drive_pose, lagging
from sim1.recording.drive_jumps import check_path
from sim1.recording.streams import Track

TURN = np.array([1.0, 0.0, 0.0, 0.0])


def track(time_s, position_m):
    """A drive that does not turn."""
    return Track(
        time_s=time_s,
        position_m=position_m,
        rotation_wxyz=np.tile(TURN, (len(time_s), 1)),
        openness=np.zeros(len(time_s)),
    )


def swung(time_s):
    """To and fro by 0.1 m, as an arm moves."""
    return np.column_stack([0.1 * np.sin(2 * np.pi * time_s), 0.0 * time_s, 0.5 + 0.0 * time_s])


def test_between_even_samples_a_drive_moves_as_smoothly_as_an_arm():
    time = np.arange(0.0, 2.0, 0.02)
    at = np.arange(0.1, 1.8, 0.003)
    position, _ = drive_pose(track(time, swung(time)), at)
    assert np.abs(position - swung(at)).max() < 1e-6


@pytest.mark.parametrize("apart_s", [5e-4, 2e-3])
def test_samples_that_came_in_a_burst_make_no_spike(apart_s):
    """One of a hundred samples a second is stamped just before the next: no fault, and where it was is known to a few millimetres."""
    time = np.arange(0.0, 2.0, 0.01)
    given = swung(time)
    stamped = time.copy()
    stamped[50] = stamped[51] - apart_s
    check_path(lambda row: f"row {row}", stamped, given, np.tile(TURN, (len(time), 1)))
    at = np.arange(0.0, 1.9, 0.001)
    position, _ = drive_pose(track(stamped, given), at)
    assert np.abs(position - swung(at)).max() < 0.01 * 2 * np.pi * 0.1 + 1e-4  # what it moves in a step


def test_a_sample_that_is_sent_twice_does_not_stop_the_drive():
    """As in recordings of a robot that sends what it sent before a tenth of a millisecond later."""
    time = np.arange(0.0, 2.0, 0.02)
    twice = np.sort(np.append(time, time[10:90:7] + 1e-4))
    places = swung(time)[np.searchsorted(time, twice - 2e-4)]
    at = np.arange(0.1, 1.8, 0.003)
    position, _ = drive_pose(track(twice, places), at)
    assert np.abs(position - swung(at)).max() < 1e-4


def test_outside_of_its_samples_a_drive_stands_still():
    time = np.arange(0.0, 1.0, 0.01)
    position, turn = drive_pose(track(time, swung(time)), np.array([-0.3, 1.4]))
    assert position == pytest.approx(swung(time)[[0, -1]])
    assert turn == pytest.approx(np.stack([np.eye(3)] * 2))


def turning(rad_s, seconds=3.0, step_s=1 / 60):
    """Rotation matrices of a gripper that stands for half a second and then turns, by more than a whole turn where it is fast."""
    time = np.arange(0.0, seconds, step_s)
    return Rotation.from_euler("z", rad_s * np.clip(time - 0.5, 0.0, None)[:, None]).as_matrix()


@pytest.mark.parametrize("rad_s", [0.5, 4.0])
def test_a_gripper_that_lags_stays_rigid_and_is_late_by_the_lag(rad_s):
    turn, lag_s, step_s = turning(rad_s), 0.15, 1 / 60
    position = np.column_stack([np.arange(len(turn)) * step_s, np.zeros((len(turn), 2))])
    late_m, late_turn = lagging(position, turn, lag_s, step_s)
    assert np.einsum("tij,tkj->tik", late_turn, late_turn) == pytest.approx(np.tile(np.eye(3), (len(turn), 1, 1)))
    assert position[-1, 0] - late_m[-1, 0] == pytest.approx(lag_s, rel=1e-3)
    behind = Rotation.from_matrix(np.einsum("ji,jk->ik", late_turn[-1], turn[-1])).as_rotvec()
    assert behind[2] == pytest.approx(rad_s * lag_s, rel=0.03)  # a mean of turns, of which 0.6 rad are no small ones
    assert behind[:2] == pytest.approx(np.zeros(2))


def test_a_gripper_that_does_not_lag_is_where_it_was_told_to_be():
    turn = turning(1.0)
    position = np.zeros((len(turn), 3))
    assert lagging(position, turn, 0.0, 1 / 60)[1] is turn
