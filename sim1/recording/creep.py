"""How far markers wander over the cloth: told by what no cloth can do, without any model of how it moves.

A marker that is stuck on keeps its place. The node of a net that a program lays over an outline sits where the program puts it, and it
wanders. That is no noise: it outlasts every average.
"""

import numpy as np

from sim1.recording.bundle import Bundle, Recording
from sim1.recording.marker_noise import marker_noise
from sim1.recording.motion import rest_until_s
from sim1.recording.sheet_fit import material_of_markers

LEAST_M = 1e-3  # less is what weight and noise do as well
FAR = 0.5  # pairs of markers farther apart than this share of the farthest: noise is little beside their distance
MOST_PAIRS = 400
FEWEST = 100  # lengths
FEWEST_FRAMES = 3  # at rest


def creep_m(bundle: Bundle) -> float | None:
    """Standard deviation [m] by coordinate of where markers are on the cloth; 0 where none is seen, None where nothing tells.

    From markers that are farther apart than on the mesh and at rest. Two grips could pull them so; only recordings with one tell.
    """
    points = material_of_markers(bundle)
    if points is None or len(points) < 2:
        return None
    apart = np.linalg.norm(points[:, None] - points, axis=-1)
    errors = np.concatenate([np.empty(0), *(_errors(r, apart) for r in bundle.recordings if len(r.holds) == 1)])
    if len(errors) < FEWEST:
        return None
    longer = errors[errors > 0]
    if len(longer) < FEWEST:
        return 0.0
    noise = [found.std_m for recording in bundle.recordings if (found := marker_noise(recording))]
    power = 0.5 * float(np.mean(longer**2)) - (float(np.median(noise)) ** 2 if noise else 0.0)  # a length has two ends
    return float(np.sqrt(power)) if power > LEAST_M**2 else 0.0


def _errors(recording: Recording, apart_m: np.ndarray) -> np.ndarray:
    """By how much distances exceed those on the mesh and at rest [m]; below 0 where cloth is bent."""
    a, b = np.triu_indices(len(apart_m), 1)
    far = np.flatnonzero(apart_m[a, b] > FAR * apart_m.max())
    far = far[:: max(1, len(far) // MOST_PAIRS)]
    a, b = a[far], b[far]
    length = apart_m[a, b]
    if recording.starts == "rest":
        seen = recording.markers_m[recording.time_s <= rest_until_s(recording)]
        told = np.isfinite(seen[..., 0]).sum(0) >= FEWEST_FRAMES
        rest = np.full(seen.shape[1:], np.nan)
        rest[told] = np.nanmedian(seen[:, told], axis=0)
        length = np.fmax(length, np.linalg.norm(rest[a] - rest[b], axis=-1))
    error = np.linalg.norm(recording.markers_m[:, a] - recording.markers_m[:, b], axis=-1) - length
    return error[np.isfinite(error)]
