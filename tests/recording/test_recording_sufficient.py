"""What a bundle lacks for a diagnosis, though it reads; what cannot be simulated: `test_mismatch_refusals.py`."""

from dataclasses import replace

import numpy as np
import pytest
from swinging import board_bundle, swing

from sim1.recording.sufficient import require_for_diagnosis
from sim1.stage import BadInput


def test_a_diagnosis_needs_two_recordings_that_move_and_markers_that_were_seen():
    require_for_diagnosis(board_bundle(swing("a"), swing("b")))
    with pytest.raises(BadInput, match="needs 2 or more"):
        require_for_diagnosis(board_bundle(swing("a")))
    with pytest.raises(BadInput, match=r"b/drives\.parquet: no drive moves"):
        require_for_diagnosis(board_bundle(swing("a"), swing("b", shift_m=0.0)))
    begun = swing("b")
    cut = replace(begun, time_s=begun.time_s[:50], markers_m=begun.markers_m[:50])
    with pytest.raises(BadInput, match=r"b/markers\.parquet: .*prediction alone"):
        require_for_diagnosis(board_bundle(swing("a"), cut))
    blind = [swing("a"), swing("b")]
    for recording in blind:
        recording.markers_m[:, 7] = np.nan
    with pytest.raises(BadInput, match=r"recordings: markers \[7\] are not visible"):
        require_for_diagnosis(board_bundle(*blind))


def test_frames_that_are_empty_between_those_of_slow_cameras_are_no_recording_to_learn_from():
    """Every other frame of 60 a second: no mean of 40 ms has more than half of its frames."""
    slow = swing("b")
    slow.markers_m[::2] = np.nan
    with pytest.raises(
        BadInput, match=r"b/markers\.parquet: of the \d+ stretches of 40 ms .* 0 % hold 3 markers .* no empty ones"
    ):
        require_for_diagnosis(board_bundle(swing("a"), slow))
