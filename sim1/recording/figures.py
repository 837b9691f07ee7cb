"""What can be measured of one recording without any model of the cloth."""

from dataclasses import dataclass

import numpy as np

from sim1.recording.bundle import Bundle, Recording
from sim1.recording.lateness import late_s
from sim1.recording.marker_noise import MarkerNoise, marker_noise
from sim1.recording.motion import COARSE, EDGE_S, free_decay_s, rest_at_end_s, rest_until_s, turn_rad, velocities
from sim1.recording.sheet_fit import SheetFit, fit_sheet, material_of_markers

MOST_FRAMES = 600  # that the sheet is fitted to; more would not change a percentile
TOUCH_M = 0.004  # above the resting height: markers have a thickness and an error
WINDOW_S = 1.0  # of motion, for how much its speed varies
FLAT_RAD, FEWEST_FLAT = 0.15, 20  # turn of the normal from a marker to its neighbour; frames
SWAY_M_S = 0.05  # a second that is slower is no motion
FOLDED_M, APART_M = 0.03, 0.12  # markers this close that are this far apart on the cloth: it is folded


@dataclass(frozen=True, kw_only=True)
class RecordingFigures:
    """Figures of one recording; None where a figure cannot be had."""

    name: str
    duration_s: float
    frame_count: int
    marker_rate_hz: float
    drive_rate_hz: float  # of the slowest drive
    seen_share: float
    worst_marker: int  # id of the marker seen least
    worst_seen_share: float
    longest_occlusion_s: float
    rest_s: float  # before the first drive moves or the first hold changes; 0 where it starts moving
    rest_at_end_s: float
    noise: MarkerNoise | None
    speed_m_s: tuple[float, float]  # of the markers in motion, 5th and 95th percentile
    normal_m_s: tuple[float, float] | None  # part of it across the cloth
    tangential_m_s: tuple[float, float] | None
    normal_windows_m_s: tuple[float, float] | None  # slowest and fastest second, 95th percentile of each
    drive_travel_m: float
    drive_turn_rad: float
    touches_table_s: float | None  # None: no table
    slides_m_s: tuple[float, float]  # along x and y, of markers on the table
    lifts: bool  # whether a marker leaves the table
    free_decay_s: float  # drives stand after a sudden stop, the cloth swings
    late_s: float | None  # markers beside the grips against their drives
    hold_count: int
    measured_holds: int  # with places_m
    changed_holds: int  # taken up or let go on the way
    open_while_held: bool
    curvature_1_m: tuple[float, float] | None  # along u and v, 95th percentile
    curvature_noise_1_m: float | None  # what noise alone would show
    strain: float | None  # largest, of warp and weft
    strain_noise: float | None
    faces: np.ndarray | None  # (n, 3) mean normals, one each MOST_FRAMES-th of the recording
    folded: bool


def measure(bundle: Bundle, recording: Recording) -> RecordingFigures:
    """Measure one recording of the bundle."""
    time, seen, velocity = recording.time_s, recording.seen, velocities(recording)
    start = rest_until_s(recording, COARSE)
    rest = 0.0 if recording.starts != "rest" else float((time[-1] if np.isinf(start) else start) - time[0])
    noise = marker_noise(recording)
    moving = (time >= time[0] + rest) if rest < time[-1] - time[0] else np.ones(len(time), bool)
    worst = int(seen.mean(0).argmin())
    every = slice(None, None, max(1, len(time) // MOST_FRAMES))
    material = material_of_markers(bundle)
    fit = None if material is None else fit_sheet(material, recording.markers_m[every])
    parts = _parts(fit, velocity[every], moving[every], time[every])
    touch, slides, lifts = _contact(bundle, recording, velocity, noise)
    core = noise.core_std_m if noise else None
    return RecordingFigures(
        name=recording.name,
        duration_s=float(time[-1] - time[0]),
        frame_count=len(time),
        marker_rate_hz=1 / float(np.median(np.diff(time))),
        drive_rate_hz=min((len(t.time_s) - 1) / float(np.ptp(t.time_s)) for t in recording.drives.values()),
        seen_share=float(seen.mean()),
        worst_marker=int(bundle.anchors.marker[worst]),
        worst_seen_share=float(seen[:, worst].mean()),
        longest_occlusion_s=_longest_gap_s(time, seen),
        rest_s=max(rest, 0.0),
        rest_at_end_s=rest_at_end_s(recording),
        noise=noise,
        speed_m_s=_range(np.linalg.norm(velocity[moving], axis=-1)) or (0.0, 0.0),
        normal_m_s=parts[0],
        tangential_m_s=parts[1],
        normal_windows_m_s=parts[2],
        drive_travel_m=max(float(np.linalg.norm(np.ptp(t.position_m, axis=0))) for t in recording.drives.values()),
        drive_turn_rad=max(float(turn_rad(track).max()) for track in recording.drives.values()),
        touches_table_s=touch,
        slides_m_s=slides,
        lifts=lifts,
        free_decay_s=free_decay_s(recording, velocity),
        late_s=late_s(bundle, recording),
        hold_count=len(recording.holds),
        measured_holds=sum(hold.places_m is not None for hold in recording.holds),
        changed_holds=sum(
            bool(hold.from_s > time[0] + EDGE_S or hold.to_s < time[-1] - EDGE_S) for hold in recording.holds
        ),
        open_while_held=_open_while_held(recording),
        curvature_1_m=None if fit is None else _bends(fit),
        curvature_noise_1_m=None if fit is None or core is None else 2 * core / fit.spacing_m**2,
        strain=None if fit is None else _strain(fit),
        strain_noise=None if fit is None or core is None else 2 * core / fit.spacing_m,
        faces=None if fit is None else _faces(fit),
        folded=material is not None and _folded(material, recording.markers_m[every]),
    )


def _range(values: np.ndarray) -> tuple[float, float] | None:
    values = values[np.isfinite(values)]
    return None if len(values) < 10 else (float(np.percentile(values, 5)), float(np.percentile(values, 95)))


def _parts(fit: SheetFit | None, velocity: np.ndarray, moving: np.ndarray, time_s: np.ndarray):
    """Ranges of normal and tangential speed, and of normal speed over windows; None each where there is no fit."""
    if fit is None:
        return None, None, None
    across = (velocity * fit.normal).sum(-1)
    along = np.linalg.norm(velocity - across[..., None] * fit.normal, axis=-1)
    across = np.abs(across)
    window = ((time_s - time_s[0]) / WINDOW_S).astype(int)
    each = [_range(across[moving & (window == index)]) for index in range(window[-1] + 1)]
    high = [found[1] for found in each if found is not None and found[1] > SWAY_M_S]
    return _range(across[moving]), _range(along[moving]), (min(high), max(high)) if high else None


def _longest_gap_s(time_s: np.ndarray, seen: np.ndarray) -> float:
    """Longest time between two sightings of a marker, less one frame; to the recording's end where it does not come back."""
    usual, longest = float(np.median(np.diff(time_s))), 0.0
    for column in seen.T:
        sightings = time_s[column]
        edges = np.concatenate([time_s[:1] - usual, sightings, time_s[-1:] + usual])
        longest = max(longest, float(np.diff(edges).max()) - usual)
    return longest if longest > 0.5 * usual else 0.0


def _contact(bundle: Bundle, recording: Recording, velocity: np.ndarray, noise: MarkerNoise | None):
    """Time that some marker is on the table, speeds along x and y there, and whether a marker lifts off."""
    table = bundle.environment.table
    if table is None:
        return None, (0.0, 0.0), False
    top = table.height_m + bundle.prior.thickness_m.value / 2 + TOUCH_M + (2 * noise.core_std_m if noise else 0.0)
    height = np.where(recording.seen, recording.markers_m[..., 2], np.inf)
    on = height < top
    steps = np.clip(np.diff(recording.time_s, append=recording.time_s[-1]), 0, 0.5)
    speeds = np.abs(velocity[on])
    speeds = speeds[np.isfinite(speeds).all(1)]
    slides = tuple(float(np.percentile(speeds[:, k], 95)) if len(speeds) >= 10 else 0.0 for k in (0, 1))
    first = np.where(on.any(0), on.argmax(0), len(on))
    after = np.arange(len(on))[:, None] > first
    lifts = bool((after & recording.seen & (height > top + 0.02)).any())
    return float(steps[on.any(1)].sum()), slides, lifts


def _open_while_held(recording: Recording) -> bool:
    for hold in recording.holds:
        track = recording.drives[hold.drive]
        during = (track.time_s > hold.from_s + EDGE_S) & (track.time_s < hold.to_s - EDGE_S)
        if during.any() and np.median(track.openness[during]) > 0.5:
            return True
    return False


def _bends(fit: SheetFit) -> tuple[float, float]:
    size = np.abs(fit.curvature_1_m)
    return tuple(float((_range(size[..., k]) or (0.0, 0.0))[1]) for k in (0, 1))


def _strain(fit: SheetFit) -> float | None:
    """How much longer than on the mesh the cloth gets: 95th percentile of time, exceeded by a tenth of the markers.

    Where the cloth bends, the chord between markers is shorter than the cloth: only nearly flat moments count.
    """
    flat = np.abs(fit.curvature_1_m).max(-1) * fit.spacing_m < FLAT_RAD
    length = np.where(flat[..., None], np.linalg.norm(fit.gradient, axis=2), np.nan)
    often = np.isfinite(length).sum(0).min(-1) >= FEWEST_FLAT
    if not often.any():
        return None
    return max(0.0, float(np.percentile(np.nanpercentile(length[:, often], 95, axis=0), 90)) - 1)


def _faces(fit: SheetFit) -> np.ndarray:
    count = np.isfinite(fit.normal[..., 0]).sum(1)
    mean = np.nansum(fit.normal, axis=1)[count >= 3]
    return mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-12)


def _folded(material_m: np.ndarray, markers_m: np.ndarray) -> bool:
    a, b = np.triu_indices(len(material_m), 1)
    apart = np.linalg.norm(material_m[a] - material_m[b], axis=1) > APART_M
    near = np.linalg.norm(markers_m[::5, a[apart]] - markers_m[::5, b[apart]], axis=-1) < FOLDED_M
    return bool(near.any(1).mean() > 0.02) if near.size else False
