"""The noise of the markers as a verdict reports it: per coordinate and frame, as the bundle states it or as it is measured at rest.

Fits work with the noise of means of 40 ms (`compare.py`), which is measured by itself: errors that outlast a frame do not average out.
"""

from dataclasses import dataclass

import numpy as np

from sim1.mismatch.compare import Observed, block_frames
from sim1.recording.bundle import Bundle
from sim1.recording.marker_noise import resting_noise_m

# Times the stated noise, or the other way round: half a second of rest tells a noise that wanders to 20 %.
CONTRADICTS = 1.5


@dataclass(frozen=True, kw_only=True)
class FrameNoise:
    """Standard deviation of a marker's coordinate in one frame."""

    std_m: float
    remark: str | None  # where it is not simply what was measured


def frame_noise(bundle: Bundle, observed: list[Observed]) -> FrameNoise:
    """What was measured at rest, else what the bundle states, else what the noise of means says if it is white, those of the fewest frames."""
    measured, stated = resting_noise_m(bundle), bundle.noise_std_m
    if measured and stated and not 1 / CONTRADICTS < measured / stated < CONTRADICTS:
        return FrameNoise(
            std_m=measured,
            remark=f"bundle.yaml states marker noise of {1e3 * stated:.2g} mm and the markers scatter by {1e3 * measured:.2g} mm at rest, by "
            "which they are judged: correct markers.noise_std_m, or see what shakes or creeps while the cloth rests",
        )
    if measured:
        return FrameNoise(std_m=measured, remark=None)
    if stated:
        return FrameNoise(
            std_m=stated,
            remark="no recording rests long enough to measure the markers' noise in a frame: it is what bundle.yaml states",
        )
    slowest = min(observed, key=block_frames)
    return FrameNoise(
        std_m=slowest.noise_m * float(np.sqrt(block_frames(slowest))),
        remark="no recording rests long enough to measure the markers' noise in a frame: it is told from means of 40 ms as if it were white",
    )
