"""Delays between markers and drives are measured from what moves as one, before any cloth is simulated."""

from dataclasses import replace

import pytest
from swinging import board_bundle, swing

from sim1.recording.bundle import write_bundle
from sim1.recording.examination import examine
from sim1.recording.lateness import FARTHEST_S, is_late, late_s


def later(recording, delay_s):
    """The recording with drives that were stamped so much earlier."""
    drives = {name: replace(track, time_s=track.time_s - delay_s) for name, track in recording.drives.items()}
    holds = tuple(replace(hold, to_s=hold.to_s - max(delay_s, 0.0)) for hold in recording.holds)
    return replace(recording, drives=drives, holds=holds)


@pytest.mark.parametrize("delay_s", [-0.12, 0.0, 0.017, 0.31])
def test_a_delay_is_found_to_a_few_milliseconds(delay_s):
    recording = later(swing("a", peak_rad_s=0.5, noise_m=5e-4, shift_m=0.3), delay_s)
    assert late_s(board_bundle(recording), recording) == pytest.approx(delay_s, abs=0.004)


def test_drives_that_hardly_move_tell_nothing():
    recording = later(swing("a", shift_m=0.0, noise_m=5e-4), 0.2)
    assert late_s(board_bundle(recording), recording) is None


def test_a_delay_beyond_what_is_tried_is_not_called_the_farthest():
    recording = later(swing("a", peak_rad_s=0.0, shift_m=0.4, moves_s=1.0), FARTHEST_S + 0.3)
    assert late_s(board_bundle(recording), recording) is None


def test_a_bundle_is_late_where_most_of_what_tells_is():
    on_time, late, still = (
        swing("a"),
        later(swing("b", seed=1), 0.26),
        later(swing("c", shift_m=0.0, noise_m=5e-4), 0.2),
    )
    assert not is_late(board_bundle(on_time, still))
    assert is_late(board_bundle(late, still))
    assert is_late(board_bundle(replace(on_time, name="d"), late, later(swing("e", seed=2), 0.3)))
    assert not is_late(board_bundle(still))


def test_the_check_says_by_how_much_markers_come_late(tmp_path):
    motions = (swing("a", peak_rad_s=0.5, shift_m=0.3), swing("b", peak_rad_s=0.5, shift_m=0.4))
    write_bundle(tmp_path / "late", board_bundle(*(later(motion, 0.26) for motion in motions)))
    write_bundle(tmp_path / "right", board_bundle(*motions))
    [said] = [s for s in examine(tmp_path / "late").statements if s.text.startswith("clocks:")]
    assert not said.can
    assert "0.26 s late" in said.text
    [said] = [s for s in examine(tmp_path / "right").statements if s.text.startswith("clocks:")]
    assert said.can
