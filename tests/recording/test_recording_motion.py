"""When a recording stops to rest."""

from dataclasses import replace

import numpy as np
import pytest
from swinging import swing

from sim1.recording.motion import COARSE, REST_S, STILL, rest_until_s


def trembling(recording, noise_m=3e-4, seed=0):
    stream = np.random.default_rng(seed)
    drives = {
        name: replace(track, position_m=track.position_m + noise_m * stream.standard_normal(track.position_m.shape))
        for name, track in recording.drives.items()
    }
    return replace(recording, drives=drives)


@pytest.mark.parametrize("still", [STILL, COARSE])
def test_rest_ends_when_a_drive_moves(still):
    assert rest_until_s(swing("a", rest_s=0.8), still) == pytest.approx(0.8, abs=0.02)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("still", [STILL, COARSE])
def test_a_recording_that_starts_at_rest_rests_for_half_a_second_however_its_drive_trembles(still, seed):
    assert REST_S <= rest_until_s(trembling(swing("a", rest_s=0.8), seed=seed), still) < 0.82


@pytest.mark.parametrize("still", [STILL, COARSE])
@pytest.mark.parametrize("noise_m", [0.0, 3e-4])
def test_a_drive_that_moves_at_once_does_not_rest(still, noise_m):
    assert rest_until_s(trembling(swing("a", rest_s=0.0), noise_m), still) < 0.05


def test_a_drive_that_turns_at_once_does_not_rest():
    assert rest_until_s(swing("a", rest_s=0.0, shift_m=0.0, turn_rad=1.0)) < 0.05


def test_a_recording_that_starts_in_motion_is_not_taken_to_rest():
    assert rest_until_s(replace(trembling(swing("a", rest_s=0.8)), starts="moving")) < 0.05


def test_what_is_let_go_ends_the_rest_and_what_is_held_to_the_end_does_not():
    still = swing("a", shift_m=0.0)
    assert rest_until_s(still) == np.inf
    [hold] = still.holds
    assert rest_until_s(replace(still, holds=(replace(hold, to_s=0.3),))) == 0.3
    assert rest_until_s(replace(still, holds=(replace(hold, from_s=0.3),))) == 0.3


def test_a_bundle_for_prediction_rests_until_its_cloth_is_let_go():
    still = swing("a", shift_m=0.0)
    [hold] = still.holds
    first = still.time_s < 0.5
    short = replace(still, time_s=still.time_s[first], markers_m=still.markers_m[first])
    assert rest_until_s(replace(short, holds=(replace(hold, to_s=2.0),))) == 2.0
