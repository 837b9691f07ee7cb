"""Marker noise, measured where the cloth rests and not where a fit would like it to be."""

from dataclasses import dataclass

import numpy as np

from sim1.mismatch.replay import rest_until_s
from sim1.recording.bundle import Bundle
from sim1.stage import BadInput

FEWEST_FRAMES = 5  # fewer give no spread


@dataclass(frozen=True, kw_only=True)
class Noise:
    """Noise of the markers per coordinate."""

    std_m: float  # root mean square, gross errors included: compares with an RMSE
    core_std_m: float  # without the tails (median absolute deviation): weights of a robust fit
    sample_count: int


def measure_noise(bundle: Bundle) -> Noise:
    """Spread of every marker around its own median while the drives rest.

    Raises:
        BadInput: the bundle states no noise and no recording has enough frames at rest.
    """
    spread, freedom = [], 0
    for recording in bundle.recordings:
        if recording.starts != "rest":
            continue
        frames = recording.markers_m[recording.time_s < rest_until_s(recording)]
        counts = np.isfinite(frames[..., 0]).sum(0)
        usable = counts >= FEWEST_FRAMES
        if not usable.any():
            continue
        off = frames[:, usable] - np.nanmedian(frames[:, usable], axis=0)
        spread.append(off[np.isfinite(off)])
        freedom += 3 * int((counts[usable] - 1).sum())
    if not spread:
        if bundle.noise_std_m is None:
            raise BadInput(
                f"bundle.yaml: markers.noise_std_m is null and no recording has {FEWEST_FRAMES} frames at rest; "
                "state the noise, or record 0.5 s before the motion starts"
            )
        return Noise(std_m=bundle.noise_std_m, core_std_m=bundle.noise_std_m, sample_count=0)
    off = np.concatenate(spread)
    core = 1.4826 * float(np.median(np.abs(off))) * (len(off) / freedom) ** 0.5
    std = float((np.square(off).sum() / freedom) ** 0.5)
    if std < 1e-7:
        raise BadInput(
            "markers.parquet: the markers do not scatter at all at rest; a camera always does: was the stream made by hand?"
        )
    return Noise(std_m=std, core_std_m=max(core, 0.2 * std), sample_count=len(off))
