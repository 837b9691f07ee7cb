"""How fast markers and drives move, and when drives rest. Cheap: differences, no model of the cloth."""

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.recording.recorded import Recording
from sim1.recording.streams import Track

STILL = 2e-4, 1e-3  # [m, rad] a drive this close to its first pose rests
COARSE = 1e-3, 0.01  # [m, rad] the same for figures that a person reads: measured poses jitter by as much all along
REST_S = 0.5  # a recording that starts at rest rests at least so long, however a measured drive trembles ...
TREMBLE = 3e-3, 0.05  # [m, rad] ... but a drive that goes as far in that time moves
STILL_M_S = 0.02  # slower than this a drive stands
SPAN_S = 0.05  # markers' speeds are differences over twice this, so that 1 mm of noise is 0.014 m/s
GRID_S = 0.01
UNTOLD_S = 0.5  # of a recording that starts moving: with a clock that is off or an actuator that lags, drives were there elsewhere before it began
EDGE_S = 0.1  # a hold that begins or ends this close to the recording's ends lasts throughout


def rest_until_s(recording: Recording, still: tuple[float, float] = STILL) -> float:
    """Time at which the first drive begins to move or the first hold changes; infinite where nothing happens.

    A drive moves once it is further than `still` (m, rad) from its first pose. A recording that starts at rest is believed to rest for
    REST_S while its drives do no more than tremble.
    """
    rests = -np.inf
    if recording.starts == "rest":
        rests = min(float(track.time_s[0]) for track in recording.drives.values()) + REST_S
    happens = [_leaves_s(track, still, rests) for track in recording.drives.values()]
    for hold in recording.holds:
        begin, end = recording.time_s[0] + EDGE_S, recording.drives[hold.drive].time_s[-1] - EDGE_S
        happens += [float(time) for time in (hold.from_s, hold.to_s) if begin < time < end]
    return min(happens)


def _leaves_s(track: Track, still: tuple[float, float], rests_s: float) -> float:
    """Time at which a drive leaves its first pose, not before `rests_s` if it only trembles until then; infinite: never."""
    away, turned = np.linalg.norm(track.position_m - track.position_m[0], axis=1), turn_rad(track)
    moves = (away > still[0]) | (turned > still[1])
    leaves = float(track.time_s[max(int(np.argmax(moves)) - 1, 0)]) if moves.any() else np.inf
    early = track.time_s < rests_s
    trembles = (away[early] < TREMBLE[0]).all() and (turned[early] < TREMBLE[1]).all()
    return max(leaves, rests_s) if trembles else leaves


def turn_rad(track: Track) -> np.ndarray:
    """Angle from the first pose of a drive, (D,)."""
    return 2 * np.arccos(np.clip(np.abs(track.rotation_wxyz @ track.rotation_wxyz[0]), 0, 1))


def velocities(recording: Recording) -> np.ndarray:
    """Velocities of the markers (T, M, 3), m/s; NaN where a marker was not seen just before and after."""
    time, markers = recording.time_s, recording.markers_m
    reach = max(1, round(SPAN_S / float(np.median(np.diff(time)))))
    found = np.full_like(markers, np.nan)
    if len(time) > 2 * reach:
        step = (time[2 * reach :] - time[: -2 * reach])[:, None, None]
        found[reach:-reach] = (markers[2 * reach :] - markers[: -2 * reach]) / step
    return found


def drive_speeds(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) from the markers' first to last frame, and the fastest drive's speed there (n,), m/s.

    A turn counts as what it does 0.1 m away from the drive's frame.
    """
    grid = np.arange(recording.time_s[0], recording.time_s[-1], GRID_S)
    speeds = np.zeros(len(grid))
    for track in recording.drives.values():
        ends = (np.clip(grid + side * SPAN_S, *track.time_s[[0, -1]]) for side in (-1, 1))
        before, after = (_pose(track, time) for time in ends)
        moved = np.linalg.norm(after[0] - before[0], axis=1)
        turned = (before[1].inv() * after[1]).magnitude()
        speeds = np.maximum(speeds, (moved + 0.1 * turned) / (2 * SPAN_S))
    return grid, speeds


def _pose(track: Track, time_s: np.ndarray) -> tuple[np.ndarray, Rotation]:
    places = np.column_stack([np.interp(time_s, track.time_s, track.position_m[:, k]) for k in range(3)])
    quaternion = np.column_stack([np.interp(time_s, track.time_s, track.rotation_wxyz[:, k]) for k in range(4)])
    return places, Rotation.from_quat(quaternion, scalar_first=True)


def free_decay_s(recording: Recording, velocity_m_s: np.ndarray) -> float:
    """Longest time that all drives stand after a sudden stop while the cloth (velocities (T, M, 3)) still swings; 0: none."""
    grid, speed = drive_speeds(recording)
    stands = np.concatenate([[0], (speed < STILL_M_S).astype(int), [0]])
    starts, ends = np.flatnonzero(np.diff(stands) == 1), np.flatnonzero(np.diff(stands) == -1)
    size = np.linalg.norm(velocity_m_s, axis=2)
    longest = 0.0
    for start, end in zip(starts, ends, strict=True):
        before = speed[max(start - 25, 0) : start]  # a quarter of a second
        begin, finish = grid[start], grid[min(end, len(grid) - 1)]
        swings = size[(recording.time_s > begin) & (recording.time_s < begin + 0.5)]
        if start and before.max() > 0.1 and np.isfinite(swings).any() and np.nanpercentile(swings, 90) > 0.05:
            longest = max(longest, float(finish - begin))
    return longest


def rest_at_end_s(recording: Recording) -> float:
    """How long all drives stand at the end of the markers."""
    grid, speed = drive_speeds(recording)
    moving = np.flatnonzero(speed >= STILL_M_S)
    return float(grid[-1] - grid[moving[-1]]) if len(moving) else 0.0
