"""Whether a bundle that reads is enough to find missing physics with, and not for prediction alone."""

import numpy as np

from sim1.cloth.precise.simulable import require_simulable
from sim1.mismatch.compare import BLOCK_S, noise_of_blocks_m, observe
from sim1.recording.bundle import Bundle
from sim1.recording.motion import COARSE, UNTOLD_S, rest_until_s
from sim1.recording.problems import Problems

FEWEST_RECORDINGS = 2
SHORTEST_MOTION_S = 0.2
FEWEST_SEEN = 3  # markers in one frame: fewer leave where the sheet is, and how it turns, open
LEAST_SHARE = 0.1  # of the frames of the motion that show as many


def require_for_diagnosis(bundle: Bundle) -> None:
    """Check that the bundle has motion to fit and motion to hold out, and all that a diagnosis asks for before it simulates.

    Raises:
        BadInput: one recording only, nothing moves, markers that end before the motion or are hidden during it, a marker that was never
            seen, markers whose noise nobody knows, or what cannot be simulated (`require_simulable`).
    """
    problems = Problems()
    names = [recording.name for recording in bundle.recordings]
    if len(names) < FEWEST_RECORDINGS:
        problems.found.append(
            f"{bundle.folder / 'bundle.yaml'}: recordings lists {names}; a diagnosis needs {FEWEST_RECORDINGS} or more, "
            "one of them to test on: record the cloth once more"
        )
    observed = [observe(recording) for recording in bundle.recordings]
    for recording, one in zip(bundle.recordings, observed, strict=True):
        place, start = bundle.folder / "recordings" / recording.name, rest_until_s(recording, COARSE)
        if np.isinf(start) and recording.starts == "rest":
            problems.found.append(
                f"{place / 'drives.parquet'}: no drive moves by 1 mm and no hold changes; move the cloth, or drop the recording"
            )
            continue
        if not np.isfinite(start):  # it starts as it is, and is not driven
            start = recording.time_s[0]
        if recording.starts == "moving":  # a fit leaves its beginning out
            start = recording.time_s[0] + UNTOLD_S
        moving = recording.time_s >= start
        fewest = min(FEWEST_SEEN, len(bundle.anchors.marker))
        share = _share(recording.seen[moving].sum(1) >= fewest)
        kept = one.kept[one.block_s >= start, :, 0].sum(1) >= fewest
        if recording.time_s[-1] < start + SHORTEST_MOTION_S:
            problems.found.append(
                f"{place / 'markers.parquet'}: markers end at {recording.time_s[-1]:.3f} s and the motion starts at {start:.3f} s; "
                "this is a bundle for prediction alone: give the markers of the motion too"
            )
        elif share < LEAST_SHARE:  # what nobody saw would else be called nothing
            problems.found.append(
                f"{place / 'markers.parquet'}: of the {moving.sum()} frames from {start:.3f} s on, where the motion starts, {100 * share:.0f} % show {FEWEST_SEEN} markers or "
                f"more, and {100 * LEAST_SHARE:.0f} % are needed: correct the column visible, or drop the recording"
            )
        elif _share(kept) < LEAST_SHARE:
            problems.found.append(
                f"{place / 'markers.parquet'}: of the {kept.size} stretches of {1e3 * BLOCK_S:.0f} ms from {start:.3f} s on, {100 * _share(kept):.0f} % hold {FEWEST_SEEN} markers or "
                f"more that are seen in most of their frames, and {100 * LEAST_SHARE:.0f} % are needed: write frames at the rate of the cameras, no empty ones between"
            )
    seen = np.any([recording.seen.any(0) for recording in bundle.recordings], axis=0)
    if not seen.all():
        problems.found.append(
            f"{bundle.folder / 'recordings'}: markers {bundle.anchors.marker[~seen].tolist()} are not visible in any markers.parquet; "
            "drop them there and in anchors.parquet, or correct their labels"
        )
    problems.attempt(noise_of_blocks_m, bundle, observed)
    problems.attempt(require_simulable, bundle)
    problems.stop()


def _share(flags: np.ndarray) -> float:
    return float(flags.mean()) if flags.size else 0.0
