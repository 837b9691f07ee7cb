"""Whether a recording that says that it starts at rest does: its simulation begins from the balance of the cloth."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from sim1.recording.marker_noise import marker_noise
from sim1.recording.motion import REST_S, TREMBLE, rest_until_s, turn_rad
from sim1.recording.recorded import Recording
from sim1.stage import BadInput

ROUNDED_S = 0.05  # by which half a second may be short
SLICE_S = 0.2  # in which the markers' speeds are told
EARLY_S = 0.3  # by which markers may be stamped ahead of their drives: a clock that is off is a mismatch to be found
RESTING_M_S = 0.05  # cloth that is faster, in the median of its markers, swings
SURE = 3.0  # standard deviations of what noise makes of a speed
FEWEST_FRAMES = 3  # in which a marker must be seen for a speed


def check_start(
    path: Path, recording: Recording, frame_place: Callable[[int], str], sample_place: Callable[[str, int], str]
) -> None:
    """Check that drives, and markers as far as no clock that is off excuses them, rest where the recording says so.

    Args:
        path: the file that says how it starts.
        recording: what to check.
        frame_place: where a frame of its markers stands, for messages.
        sample_place: the same of a drive's name and sample.

    Raises:
        BadInput: a drive goes further than it may tremble in the first half second, or the cloth moves before its drives.
    """
    if recording.starts != "rest":
        return
    remedy = f"write `starts: moving` for {recording.name} in {path.name}, or begin it {REST_S} s before the motion"
    for name, track in sorted(recording.drives.items()):
        early = track.time_s < track.time_s[0] + REST_S - ROUNDED_S
        away, turned = np.linalg.norm(track.position_m - track.position_m[0], axis=1), turn_rad(track)
        if (moves := early & ((away > TREMBLE[0]) | (turned > TREMBLE[1]))).any():
            at = int(np.argmax(moves))
            raise BadInput(
                f"{sample_place(name, at)}: {path.name} says that the recording starts at rest, and drive {name!r} has moved by "
                f"{away[at]:.3g} m and {turned[at]:.3g} rad at {track.time_s[at]} s, {track.time_s[at] - track.time_s[0]:.3g} s after its "
                f"first sample; {remedy}"
            )
    begin = float(recording.time_s[0])
    until = begin + min(max(rest_until_s(recording) - begin - EARLY_S, SLICE_S), REST_S)
    noise = marker_noise(recording)
    for start in np.arange(begin, until - SLICE_S + 1e-9, SLICE_S / 2):
        told = noise and _speed_m_s(recording, float(start), noise.core_std_m)
        if told is not None and told[0] > max(RESTING_M_S, SURE * told[1]):
            raise BadInput(
                f"{frame_place(int(np.searchsorted(recording.time_s, start - 1e-9)))}: {path.name} says that the recording starts at rest, and its markers move at {told[0]:.3g} m/s "
                f"in the frames from {start:.3f} to {start + SLICE_S:.3f} s; {remedy}, once the cloth hangs still"
            )


def _speed_m_s(recording: Recording, start_s: float, noise_m: float) -> tuple[float, float] | None:
    """Median speed of the markers over `SLICE_S`, by straight lines, and what noise alone makes of it; None: too few are seen.

    Of slow cameras over as many frames as a line needs.
    """
    first, last = np.searchsorted(recording.time_s, [start_s - 1e-9, start_s + SLICE_S])
    rows = slice(first, max(last, first + FEWEST_FRAMES))
    time, places = recording.time_s[rows], recording.markers_m[rows]
    seen = np.isfinite(places).all(-1)
    enough = seen.sum(0) >= FEWEST_FRAMES
    if not enough.any():
        return None
    weight = seen[:, enough].astype(float)
    off = time[:, None] - (weight * time[:, None]).sum(0) / weight.sum(0)
    moment = weight * off
    power = (moment * off).sum(0)
    slope = (moment[..., None] * np.nan_to_num(places[:, enough])).sum(0) / power[:, None]
    scatter = noise_m * np.sqrt(3.0 / power)
    return float(np.median(np.linalg.norm(slope, axis=1))), float(np.median(scatter))
