"""What a recording says of its start is held against its drives and its markers."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from swinging import board_bundle, swing

from sim1.recording.bundle import read_bundle, write_bundle
from sim1.recording.starts import check_start
from sim1.stage import BadInput


def checked(recording):
    check_start(
        Path("bundle.yaml"),
        recording,
        lambda frame: f"recordings/a/markers.parquet: row {16 * frame}",
        lambda drive, sample: f"recordings/a/drives.parquet: row {sample}",
    )


def later(recording, delay_s):
    """Markers that are stamped so much later than they were seen."""
    return replace(recording, time_s=recording.time_s + delay_s)


def swings_on(recording, speed_m_s):
    """The cloth swings all along, its drives still at rest."""
    wave = speed_m_s / 6.0 * np.sin(6.0 * recording.time_s)
    return replace(recording, markers_m=recording.markers_m + wave[:, None, None] * np.array([0.0, 1.0, 0.0]))


@pytest.mark.parametrize("noise_m", [0.0, 2e-3])
@pytest.mark.parametrize("rate_hz", [10.0, 100.0])
def test_a_recording_that_rests_for_half_a_second_passes(noise_m, rate_hz):
    for seed in range(5):
        checked(swing("a", rest_s=0.5, noise_m=noise_m, rate_hz=rate_hz, seed=seed))


def test_a_drive_that_moves_at_once_is_refused_with_file_time_value_and_remedy():
    said = r"recordings/a/drives\.parquet: row \d+: bundle\.yaml says .*starts at rest.*'bar' has moved by 0\.00\d+ m .* at 0\.\d+ s.*`starts: moving`"
    with pytest.raises(BadInput, match=said):
        checked(swing("a", rest_s=0.0))
    with pytest.raises(BadInput, match=r"drives\.parquet"):
        checked(swing("a", rest_s=0.2, shift_m=0.0, turn_rad=1.0))


@pytest.mark.parametrize("rate_hz", [10.0, 100.0])
def test_cloth_that_swings_while_its_drives_rest_is_refused(rate_hz):
    still = swing("a", rest_s=1.0, noise_m=5e-4, rate_hz=rate_hz)
    checked(swings_on(still, 0.02))
    with pytest.raises(
        BadInput, match=r"recordings/a/markers\.parquet: row 0: .*move at 0\.\d+ m/s in the frames from .*hangs still"
    ):
        checked(swings_on(still, 0.2))


@pytest.mark.parametrize("delay_s", [-0.3, 0.3])
def test_a_clock_that_is_off_is_a_mismatch_to_be_found_and_no_motion_at_the_start(delay_s):
    recording = later(swing("a", rest_s=0.55, noise_m=5e-4), delay_s)
    from_zero = recording.time_s >= 0.0
    checked(replace(recording, time_s=recording.time_s[from_zero], markers_m=recording.markers_m[from_zero]))


def test_what_starts_moving_may_move_and_a_bundle_is_read_by_the_same_rule(tmp_path):
    moving = replace(swing("a", rest_s=0.0), starts="moving")
    write_bundle(tmp_path / "moving", board_bundle(moving, swing("b")))
    assert [one.starts for one in read_bundle(tmp_path / "moving").recordings] == ["moving", "rest"]
    write_bundle(tmp_path / "resting", board_bundle(replace(moving, starts="rest"), swing("b")))
    with pytest.raises(BadInput, match=r"recordings/a/drives\.parquet: row \d+: bundle\.yaml says .*starts at rest"):
        read_bundle(tmp_path / "resting")
