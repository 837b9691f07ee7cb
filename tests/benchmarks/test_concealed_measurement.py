"""What the laboratory's clocks and cameras get wrong."""

import numpy as np
import pytest

from benchmarks.concealed.effects.measurement import CameraScale, ClockOffset, FrameOffset, RollingShutter


def test_measurement_effects_follow_the_format():
    def sample(times: np.ndarray) -> np.ndarray:
        return np.stack([times, 2 * times, 0 * times + np.arange(times.shape[1])], axis=-1)

    stamps = np.repeat(np.linspace(1, 2, 5)[:, None], 3, axis=1)
    late = ClockOffset({"offset": 0.02}, {"drift": 0.0}).observe(stamps, sample)
    assert late[:, 0, 0] == pytest.approx(stamps[:, 0] - 0.02)
    frame = FrameOffset({"tx": 0.1, "ty": 0, "tz": 0, "rx": 0, "ry": 0, "rz": np.pi / 2})
    x = sample(stamps)
    assert frame.observe(stamps, sample)[..., 0] == pytest.approx(0.1 - x[..., 1])
    assert frame.observe(stamps, sample)[..., 1] == pytest.approx(x[..., 0])
    shutter = RollingShutter({"readout": 0.01}).observe(stamps, sample)
    assert shutter[:, 2] == pytest.approx(x[:, 2])
    assert shutter[:, 0, 0] == pytest.approx(x[:, 0, 0] + 0.02)
    scaled = CameraScale({"scale": 1.01}, {"x": 1.0, "y": 0.0, "z": 0.0}).observe(stamps, sample)
    assert scaled[..., 0] == pytest.approx(1 + 1.01 * (x[..., 0] - 1))


def test_a_clock_that_drifts_is_off_by_its_offset_on_the_mean_of_a_recording():
    clock = ClockOffset({"offset": 0.02}, {"drift": 8e-5})
    true_s = np.linspace(0, 4, 9)
    stamps = true_s + 0.02 + 8e-5 * (true_s - 2)
    seen = clock.observe(stamps[:, None], lambda times: np.repeat(times[..., None], 3, axis=-1))
    assert seen[:, 0, 0] == pytest.approx(true_s, abs=1e-12)
    assert (stamps - true_s).mean() == pytest.approx(0.02)
    assert np.abs(stamps - true_s - 0.02).max() < 2e-4
