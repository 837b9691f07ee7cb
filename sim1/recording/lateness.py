"""By how much markers come late against the drives, from what moves as one: cloth right beside a grip."""

import numpy as np

from sim1.cloth.precise.drives import drive_pose
from sim1.recording.bundle import Bundle, Hold, Recording

FARTHEST_S, STEP_S = 0.5, 0.01  # of the delays that are tried
BESIDE_M = 0.03  # markers no more than this farther from a grip than the nearest one
MOST_MARKERS = 12
TOLD = 1.3  # times the rms of the best delay that the scatter must reach within `WINDOW_S` of it: else the motion is too slow to tell
WINDOW_S = 0.2
FEWEST = 40  # sightings
LATE_S = 0.04  # cloth beside a grip trails it by up to 0.02 s where nothing is late


def late_s(bundle: Bundle, recording: Recording) -> float | None:
    """Delay [s] at which markers beside the grips keep still in their drives' frames best; None where nothing tells.

    A delay holds whatever makes markers late: a clock that is off, a camera's latency, an actuator that lags.
    """
    delays = np.arange(-FARTHEST_S, FARTHEST_S + STEP_S / 2, STEP_S)
    power, count = np.zeros(len(delays)), 0
    for hold in recording.holds:
        beside = _beside(bundle, hold)
        inside = (recording.time_s > hold.from_s) & (recording.time_s < hold.to_s)
        seen = recording.markers_m[inside][:, beside]
        count += int(np.isfinite(seen[..., 0]).sum())
        power += [_scatter(recording, hold, recording.time_s[inside] - delay, seen) for delay in delays]
    if count < FEWEST:
        return None
    best = int(power.argmin())
    near = np.abs(delays - delays[best]) <= WINDOW_S
    edges = power[near][[0, -1]]
    if best in (0, len(delays) - 1) or np.sqrt(edges.min() / max(power[best], 1e-30)) < TOLD:
        return None
    before, at, after = power[best - 1 : best + 2]
    return float(delays[best] + 0.5 * STEP_S * (before - after) / max(before - 2 * at + after, 1e-30))


def is_late(bundle: Bundle) -> bool:
    """Whether markers come late, or early, in the median of the recordings that tell."""
    told = [delay for recording in bundle.recordings if (delay := late_s(bundle, recording)) is not None]
    return bool(told) and abs(float(np.median(told))) >= LATE_S


def _beside(bundle: Bundle, hold: Hold) -> np.ndarray:
    """Columns of the markers nearest to what is held."""
    anchors, vertices = bundle.anchors, bundle.mesh.vertices_m
    points = (vertices[bundle.mesh.faces[anchors.face]] * anchors.weight[..., None]).sum(1)
    away = np.linalg.norm(points[:, None] - vertices[hold.vertices], axis=-1).min(1)
    return np.argsort(away, kind="stable")[: min(MOST_MARKERS, int((away < away.min() + BESIDE_M).sum()))]


def _scatter(recording: Recording, hold: Hold, time_s: np.ndarray, seen_m: np.ndarray) -> float:
    """Sum of squares [m^2] of markers (N, M, 3) about their medians in the drive's frame at `time_s` (N,)."""
    track = recording.drives[hold.drive]
    position, turn = drive_pose(track, np.clip(time_s, track.time_s[0], track.time_s[-1]))
    local = np.einsum("tji,tmj->tmi", turn, seen_m - position[:, None])
    with np.errstate(invalid="ignore"):
        off = local[:, np.isfinite(local[..., 0]).any(0)]
    return float(np.nansum((off - np.nanmedian(off, axis=0)) ** 2))
