"""Where the cloth sits in its grips: one place for all recordings, or each its own."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.cloth.precise.held_places import held_places
from sim1.cloth.precise.scene import prepare
from sim1.mismatch.search import baseline

ALONG_M = np.array([0.03, 0.0, 0.0])


def with_recording(bundle, number, changed):
    """The bundle with one recording changed."""
    recordings = list(bundle.recordings)
    recordings[number] = changed(recordings[number])
    return replace(bundle, recordings=tuple(recordings))


def taken_up_beside(recording):
    """The same motion with the cloth held three centimetres further along the bar."""
    return replace(recording, markers_m=recording.markers_m + ALONG_M)


def measured_beside(recording):
    """The same, and the lab has measured it."""
    hold = recording.holds[0]
    return replace(recording, holds=(replace(hold, places_m=hold.places_m + ALONG_M), *recording.holds[1:]))


def test_recordings_share_a_place_that_nobody_measured():
    held = held_places(empty_bundle(measured=False))
    assert [key[2] for key in held.keys] == [""]
    assert not held.measured


def test_a_recording_for_which_the_cloth_was_taken_up_anew_has_places_of_its_own():
    bundle = with_recording(empty_bundle(measured=False), 1, taken_up_beside)
    held, names = held_places(bundle), [one.name for one in bundle.recordings]
    assert [key[2] for key in held.keys] == sorted(names)
    middles = {key[2]: held.places_m[key].mean(0) for key in held.keys}
    assert middles[names[1]] - middles[names[0]] == pytest.approx(ALONG_M, abs=1e-6)
    assert sum(c.name.startswith("place/") for c in baseline(bundle).nominal) == 6 * len(names)


def test_places_that_a_lab_measured_anew_each_time_are_taken_as_they_are():
    bundle = with_recording(empty_bundle(), 1, measured_beside)
    held = held_places(bundle)
    assert held.measured == set(held.keys)
    for recording in bundle.recordings:
        grip = prepare(bundle, recording, 1 / 60).grips[0]
        expected = recording.holds[0].places_m[np.argsort(recording.holds[0].vertices)]
        assert np.sort(grip.places_m, axis=0) == pytest.approx(np.sort(expected, axis=0))
    assert not any(c.name.startswith("place/") for c in baseline(bundle).nominal)
