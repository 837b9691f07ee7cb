"""The noise that a verdict tells is that of single frames, as a bundle states it."""

from dataclasses import replace

import numpy as np
import pytest
from small_bundle import empty_bundle

from sim1.mismatch.engine import Engine
from sim1.mismatch.noise import frame_noise

NOISE_M, RATE_HZ = 8e-4, 200.0


def shaken(stated_m=None, starts="rest", seed=0):
    """Markers filmed 200 times a second, eight frames to a mean of 40 ms."""
    bundle, stream = empty_bundle(motions=2), np.random.default_rng(seed)
    recordings = []
    for recording in bundle.recordings:
        time = np.arange(0.0, recording.time_s[-1], 1 / RATE_HZ)
        still = np.repeat(recording.markers_m[:1], len(time), axis=0)
        shaking = still + NOISE_M * stream.standard_normal(still.shape)
        recordings.append(replace(recording, starts=starts, time_s=time, markers_m=shaking))
    return replace(bundle, noise_std_m=stated_m, recordings=tuple(recordings))


def told(bundle):
    with Engine(bundle, processes=1) as engine:
        observed = [engine.observed(name) for name in engine.names]
        assert len({one.noise_m for one in observed}) == 1
        return observed[0].noise_m, frame_noise(bundle, observed)


def at(recording, rate_hz, seed, starts="rest"):
    """The recording filmed so often, the sheet still."""
    time = np.arange(0.0, recording.time_s[-1], 1 / rate_hz)
    still = np.repeat(recording.markers_m[:1], len(time), axis=0)
    noise = NOISE_M * np.random.default_rng(seed).standard_normal(still.shape)
    return replace(recording, starts=starts, time_s=time, markers_m=still + noise)


def noises(bundle):
    with Engine(bundle, processes=1) as engine:
        return [engine.observed(name).noise_m for name in engine.names]


def test_each_recording_has_the_noise_of_means_over_its_own_frames():
    bundle = empty_bundle(motions=3)
    filmed = [
        at(one, rate, k) for k, (one, rate) in enumerate(zip(bundle.recordings, (50.0, 200.0, 200.0), strict=True))
    ]
    slow, fast, other = noises(replace(bundle, recordings=tuple(filmed)))
    assert fast == other == pytest.approx(NOISE_M / np.sqrt(8), rel=0.1)
    assert slow == pytest.approx(NOISE_M / np.sqrt(2), rel=0.1)


def test_a_recording_that_does_not_rest_has_the_noise_of_others_by_its_own_frames():
    bundle = empty_bundle(motions=2)
    resting, moving = at(bundle.recordings[0], 200.0, 0), at(bundle.recordings[1], 50.0, 1, starts="moving")
    fast, slow = noises(replace(bundle, recordings=(resting, moving)))
    assert slow == pytest.approx(2 * fast)


def test_noise_is_told_by_frame_and_fits_use_that_of_means():
    of_means, noise = told(shaken())
    assert noise.std_m == pytest.approx(NOISE_M, rel=0.05)
    assert of_means == pytest.approx(NOISE_M / np.sqrt(8), rel=0.1)
    assert noise.remark is None


def test_a_stated_noise_that_is_borne_out_changes_nothing():
    assert told(shaken(stated_m=7e-4)) == told(shaken())


@pytest.mark.parametrize("stated_m", [2e-4, 2e-3])
def test_a_stated_noise_that_the_markers_contradict_is_told_with_both_figures(stated_m):
    _, noise = told(shaken(stated_m=stated_m))
    assert noise.std_m == pytest.approx(NOISE_M, rel=0.05)
    assert f"states marker noise of {1e3 * stated_m:.2g} mm" in noise.remark
    assert f"{1e3 * noise.std_m:.2g} mm at rest" in noise.remark


def test_where_nothing_rests_the_stated_noise_is_taken_and_said_to_be():
    of_means, noise = told(shaken(stated_m=5e-4, starts="moving"))
    assert (noise.std_m, of_means) == (5e-4, pytest.approx(5e-4 / np.sqrt(8)))
    assert "what bundle.yaml states" in noise.remark
