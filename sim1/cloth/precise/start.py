"""How the sheet lies when a recording starts, as its markers tell."""

from pathlib import Path

import numpy as np
from scipy.interpolate import RBFInterpolator

from sim1.cloth.precise.mesh import Sheet
from sim1.recording.bundle import Bundle, Recording
from sim1.recording.motion import rest_until_s
from sim1.stage import BadInput

START_S = 0.1  # of a recording that starts in motion: from these frames come its first shape and velocity
FEWEST_FRAMES, FEWEST_CURVED = 4, 6  # in which a marker must be seen then, for a straight path and for a parabola
FEWEST_MARKERS, FEWEST_SMOOTH = 3, 6  # that tell a plane, and how the sheet curves
ON_A_LINE = 0.01  # markers that spread no wider than this share of their length leave the turn about them open


def start_of(
    bundle: Bundle, recording: Recording, points_m: np.ndarray, sheet: Sheet
) -> tuple[np.ndarray, np.ndarray | None]:
    """Shape (V, 3), and velocity (V, 3) where the recording starts in motion, from markers at material points (M, 2).

    Raises:
        BadInput: too few markers are seen at the start, or all on one line.
    """
    if recording.starts == "rest":
        shape, velocity = resting_shape(bundle, recording, points_m, sheet), None
    else:
        shape, velocity = _moving(bundle, recording, points_m, sheet)
    if bundle.environment.table is not None:
        shape[:, 2] = np.maximum(shape[:, 2], table_z(bundle))
    return shape, velocity


def resting_shape(bundle: Bundle, recording: Recording, points_m: np.ndarray, sheet: Sheet) -> np.ndarray:
    """Shape (V, 3) of a recording that starts at rest: medians of its markers until anything moves, spread over the mesh.

    Raises:
        BadInput: too few markers are seen then, or all on one line.
    """
    first = recording.time_s[0]
    until = max(rest_until_s(recording), first + 0.05)
    rows = recording.time_s <= until
    median = np.full(recording.markers_m.shape[1:], np.nan)
    for m in range(len(median)):
        seen = recording.markers_m[rows, m]
        seen = seen[np.isfinite(seen[:, 0])]
        if len(seen):
            median[m] = np.median(seen, axis=0)
    place = f"{_path(bundle, recording)}: at rest, until {min(until, recording.time_s[-1]):.3f} s,"
    return spread_over(points_m, median, sheet.material_m, place)


def _moving(bundle: Bundle, recording: Recording, points_m: np.ndarray, sheet: Sheet) -> tuple[np.ndarray, np.ndarray]:
    """Shape and velocity (V, 3) at the first frame, or where drives begin after it, from paths fitted to each marker's first frames from then on."""
    at_s = max(float(recording.time_s[0]), min(track.time_s[0] for track in recording.drives.values()))
    first = int(np.searchsorted(recording.time_s, at_s - 1e-9))
    rows = (recording.time_s >= at_s - 1e-9) & (recording.time_s <= at_s + START_S)
    rows[first : first + FEWEST_FRAMES] = True  # of slow cameras
    time = recording.time_s[rows] - at_s
    places, speeds = np.full((2, *recording.markers_m.shape[1:]), np.nan)
    for m in range(len(places)):
        seen = np.isfinite(recording.markers_m[rows, m, 0])
        if seen.sum() >= FEWEST_FRAMES:
            degree = 2 if seen.sum() >= FEWEST_CURVED else 1
            fit = np.polyfit(time[seen], recording.markers_m[rows, m][seen], degree)
            places[m], speeds[m] = fit[-1], fit[-2]
    place = f"{_path(bundle, recording)}: in {FEWEST_FRAMES} or more of the first {len(time)} frames{_from(recording, at_s)}"
    shape, velocity = (spread_over(points_m, part, sheet.material_m, place) for part in (places, speeds))
    return shape, velocity


def _from(recording: Recording, at_s: float) -> str:
    return "" if at_s <= recording.time_s[0] else f" from {at_s:.3f} s on, where its drives begin"


def _path(bundle: Bundle, recording: Recording) -> Path:
    return bundle.folder / "recordings" / recording.name / "markers.parquet"


def spread_over(points_m: np.ndarray, values: np.ndarray, at_m: np.ndarray, place: str) -> np.ndarray:
    """Values (M, 3) known at material points (M, 2), smoothly at others (V, 2), as (V, 3); what is NaN is left out.

    `place` begins the message of an error.

    Raises:
        BadInput: fewer than three markers are known, or all on one line.
    """
    known = np.isfinite(values).all(1)
    count = int(known.sum())
    if count < FEWEST_MARKERS:
        raise BadInput(
            f"{place} {count} of {len(values)} markers are seen; {FEWEST_MARKERS} or more tell how the cloth lies: "
            "begin the recording where they are seen, or give the cloth more markers"
        )
    spread = np.linalg.svd(points_m[known] - points_m[known].mean(0), compute_uv=False)
    if spread[1] < ON_A_LINE * spread[0]:
        raise BadInput(
            f"{place} the {count} markers that are seen lie on one line of the cloth, within {spread[1]:.2g} m; "
            "begin the recording where one beside it is seen, or give the cloth one"
        )
    # A plane through all of them, and what is left spread between them: five points are too few to tell how a sheet curves.
    kernel = "thin_plate_spline" if count >= FEWEST_SMOOTH else "linear"
    return RBFInterpolator(points_m[known], values[known], kernel=kernel, degree=1, smoothing=1e-7)(at_m)


def table_z(bundle: Bundle) -> float:
    """Height at which the middle surface of a lying sheet rests, m."""
    table = bundle.environment.table
    return float(table.height_m + 0.5 * bundle.prior.thickness_m.value)
