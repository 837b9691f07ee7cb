"""Smooth courses of one coordinate over time: no jump in position, speed or acceleration."""

import numpy as np


def rise(time_s: np.ndarray, start_s: float, duration_s: float) -> np.ndarray:
    """0 before, 1 after, minimum jerk between; the largest speed is 1.875 / duration."""
    s = np.clip((np.asarray(time_s, dtype=float) - start_s) / duration_s, 0.0, 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2)


def there_and_back(time_s: np.ndarray, start_s: float, duration_s: float, wait_s: float) -> np.ndarray:
    """0 to 1, wait, and back to 0; each way takes duration_s."""
    return rise(time_s, start_s, duration_s) - rise(time_s, start_s + duration_s + wait_s, duration_s)


def wave(time_s: np.ndarray, start_s: float, end_s: float, rate_hz: float, ramp_s: float = 0.4) -> np.ndarray:
    """A sine of amplitude 1 that fades in and out over ramp_s within start_s to end_s."""
    window = rise(time_s, start_s, ramp_s) - rise(time_s, end_s - ramp_s, ramp_s)
    return window * np.sin(2 * np.pi * rate_hz * (np.asarray(time_s, dtype=float) - start_s))
