"""How much the markers scatter, and for how long an error stays: from the rest phase, or from the motion as an upper bound."""

from dataclasses import dataclass

import numpy as np

from sim1.recording.motion import COARSE, rest_until_s
from sim1.recording.recorded import Bundle, Recording

FEWEST_FRAMES = 5  # at rest; fewer give no spread
FEWEST_FOR_CORRELATION = 12
LEAST_SHARE = 0.15  # less is what a short rest shows of white noise too
MAD_TO_STD = 1.4826


@dataclass(frozen=True, kw_only=True)
class MarkerNoise:
    """Scatter of the markers per coordinate."""

    std_m: float  # root mean square, gross errors included
    core_std_m: float  # without the tails
    slow_share: float | None  # of the variance, that outlasts a frame; None: too few frames
    correlation_s: float | None  # in which that part falls to 1 / e; 0: there is none
    at_rest: bool  # False: from differences of the motion, an upper bound


def marker_noise(recording: Recording) -> MarkerNoise | None:
    """The noise of one recording, or None where markers are too few or too rarely seen."""
    still = recording.time_s < (rest_until_s(recording, COARSE) if recording.starts == "rest" else recording.time_s[0])
    frames, time = recording.markers_m[still], recording.time_s[still]
    counts = np.isfinite(frames[..., 0]).sum(0)
    if (counts >= FEWEST_FRAMES).any():
        off, freedom = _without_drift(time, frames[:, counts >= FEWEST_FRAMES])
        scatter = off[np.isfinite(off)]
        share = (len(scatter) / freedom) ** 0.5
        std = float(np.sqrt(np.square(scatter).sum() / freedom))
        core = MAD_TO_STD * float(np.median(np.abs(scatter))) * share
        share, time_s = _slow_part(off, float(np.median(np.diff(time))))
        return MarkerNoise(std_m=std, core_std_m=core, slow_share=share, correlation_s=time_s, at_rest=True)
    bend = np.diff(recording.markers_m, n=3, axis=0)  # of white noise: variance 20
    bend = bend[np.isfinite(bend)] / 20**0.5
    if len(bend) < 30:
        return None
    core = MAD_TO_STD * float(np.median(np.abs(bend)))
    return MarkerNoise(
        std_m=float(np.sqrt(np.mean(bend**2))), core_std_m=core, slow_share=None, correlation_s=None, at_rest=False
    )


def resting_noise_m(bundle: Bundle) -> float | None:
    """Standard deviation of a marker's coordinate in a frame, gross errors included; None where no recording rests long enough.

    The median of the recordings that do.
    """
    noises = [marker_noise(recording) for recording in bundle.recordings]
    measured = [noise.std_m for noise in noises if noise is not None and noise.at_rest]
    return float(np.median(measured)) if measured else None


def _without_drift(time_s: np.ndarray, frames_m: np.ndarray) -> tuple[np.ndarray, int]:
    """Positions (T, M, 3) less each one's straight line over time, and how many of them are left free."""
    seen = np.isfinite(frames_m)
    count = seen.sum(0)
    moment = np.where(seen, (time_s - time_s.mean())[:, None, None], 0.0)
    moment = np.where(seen, moment - moment.sum(0) / count, 0.0)
    value = np.where(seen, frames_m, 0.0)
    value = np.where(seen, value - value.sum(0) / count, 0.0)
    slope = (moment * value).sum(0) / np.maximum((moment**2).sum(0), 1e-30)
    return np.where(seen, value - slope * moment, np.nan), int((count - 2).sum())


def _slow_part(off_m: np.ndarray, step_s: float) -> tuple[float | None, float | None]:
    """Share of the variance of residuals (T, M, 3) that outlasts a frame, and the time in which that part falls to 1 / e."""
    count = len(off_m)
    if count < FEWEST_FOR_CORRELATION:
        return None, None
    core = np.nanmedian(np.abs(off_m)) * MAD_TO_STD
    off = np.clip(off_m, -4 * core, 4 * core)  # one gross error must not decide
    variance = np.nanmean(off * off)
    if not variance > 0:
        return None, None
    share = before = _correlation(off, 1, variance)
    if share < LEAST_SHARE:
        return 0.0, 0.0
    for lag in range(2, count // 2):
        now = _correlation(off, lag, variance)
        if now < share / np.e:
            across = (before - share / np.e) / (before - now)
            return share, float(step_s * (lag - 2 + across))
        before = now
    return share, step_s * (count // 2)


def _correlation(off_m: np.ndarray, lag: int, variance: float) -> float:
    product = off_m[lag:] * off_m[:-lag]
    if not np.isfinite(product).any():
        return 0.0
    return float(np.nanmean(product) / variance) + 2 / len(off_m)  # the straight line took as much away
