"""Where the cloth sits in its grips: one place for all recordings, or each its own."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.cloth.precise.held_places import held_places
from sim1.cloth.precise.scene import prepare
from sim1.mismatch.model_file import with_grips
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


def let_go_and_taken_up_again(bundle, first_m, second_m):
    """Its first recording with the same vertices held twice, at these places."""

    def changed(recording):
        hold = recording.holds[0]
        holds = replace(hold, to_s=0.9, places_m=first_m), replace(hold, from_s=1.1, places_m=second_m)
        return replace(recording, holds=holds)

    return with_recording(bundle, 0, changed)


def test_vertices_that_are_taken_up_a_second_time_have_places_of_their_own():
    places = empty_bundle().recordings[0].holds[0].places_m
    bundle = let_go_and_taken_up_again(empty_bundle(), places, places + ALONG_M)
    first, second = prepare(bundle, bundle.recordings[0], 1 / 60).grips
    assert second.places_m - first.places_m == pytest.approx(np.broadcast_to(ALONG_M, places.shape))
    assert held_places(bundle).measured == set(held_places(bundle).keys)


def test_a_place_that_is_null_is_calibrated_though_the_same_grip_was_measured_another_time():
    places = empty_bundle().recordings[0].holds[0].places_m
    bundle = let_go_and_taken_up_again(empty_bundle(measured=False), None, places + ALONG_M)
    first, second = prepare(bundle, bundle.recordings[0], 1 / 60).grips
    assert first.places_m.mean(0) == pytest.approx(places.mean(0), abs=1e-6)
    assert second.places_m.mean(0) == pytest.approx((places + ALONG_M).mean(0))
    assert sum(c.name.startswith("place/") for c in baseline(bundle).nominal) == 6


def test_a_place_that_is_null_where_nothing_rests_is_sought_from_where_others_measured_it():
    def unknown(recording):
        return replace(recording, starts="moving", holds=(replace(recording.holds[0], places_m=None),))

    bundle = with_recording(empty_bundle(), 1, unknown)
    held = held_places(bundle)
    key = held.key(bundle.recordings[1], bundle.recordings[1].holds[0])
    assert key not in held.measured
    assert held.places_m[key] == pytest.approx(bundle.recordings[0].holds[0].places_m)


def test_a_model_knows_where_the_cloth_was_held_unless_it_was_taken_up_anew_since():
    bundle = empty_bundle(measured=False)
    key = held_places(bundle).keys[0]
    where = held_places(bundle).places_m[key]
    grip = {"drive": key[0], "vertices": list(key[1]), "places_m": (where + 0.1 * ALONG_M).tolist()}
    known = SimpleNamespace(grips=(grip,))
    same = with_grips(bundle, known)
    assert same.recordings[1].holds[0].places_m == pytest.approx(where + 0.1 * ALONG_M)
    moved = with_grips(with_recording(bundle, 1, lambda one: replace(one, markers_m=one.markers_m + 0.05)), known)
    assert [one.holds[0].places_m is None for one in moved.recordings] == [False, True, False]
