"""How the sheet lies when a recording starts, as its markers tell."""

import numpy as np
from scipy.interpolate import RBFInterpolator

from sim1.cloth.precise.mesh import Sheet
from sim1.recording.bundle import Bundle, Recording
from sim1.recording.motion import rest_until_s
from sim1.stage import BadInput


def start_of(
    recording: Recording, points: np.ndarray, sheet: Sheet, bundle: Bundle
) -> tuple[np.ndarray, np.ndarray | None]:
    """Shape, and velocity where the recording starts in motion, both spread from the markers over the mesh."""
    if recording.starts == "rest":
        shape, velocity = spread_over(points, resting_markers(recording), sheet.material_m), None
    else:
        rows = recording.time_s <= recording.time_s[0] + 0.1
        time = recording.time_s[rows] - recording.time_s[0]
        places, speeds = np.full((2, *recording.markers_m.shape[1:]), np.nan)
        for m in range(len(places)):
            seen = np.isfinite(recording.markers_m[rows, m, 0])
            if seen.sum() >= 4:
                fit = np.polyfit(time[seen], recording.markers_m[rows, m][seen], 2 if seen.sum() >= 6 else 1)
                places[m], speeds[m] = fit[-1], fit[-2]
        shape, velocity = (spread_over(points, part, sheet.material_m) for part in (places, speeds))
    if bundle.environment.table is not None:
        shape[:, 2] = np.maximum(shape[:, 2], table_z(bundle))
    return shape, velocity


def resting_markers(recording: Recording) -> np.ndarray:
    """Median place (M, 3) of each marker before anything moves; NaN where it was never seen then."""
    first = recording.time_s[0]
    until = rest_until_s(recording) if recording.starts == "rest" else first + 0.05
    rows = recording.time_s <= max(until, first + 0.05)
    out = np.full(recording.markers_m.shape[1:], np.nan)
    for m in range(out.shape[0]):
        seen = recording.markers_m[rows, m]
        seen = seen[np.isfinite(seen[:, 0])]
        if len(seen):
            out[m] = np.median(seen, axis=0)
    return out


def spread_over(points_m: np.ndarray, values: np.ndarray, at_m: np.ndarray) -> np.ndarray:
    """Values (M, 3) known at material points, smoothly everywhere (V, 3); what is NaN is left out.

    Raises:
        BadInput: fewer than 3 markers are known.
    """
    known = np.isfinite(values).all(1)
    if known.sum() < 3:
        raise BadInput(
            f"markers.parquet: only {known.sum()} markers are seen at the start; 3 or more tell how it hangs"
        )
    # A plane through all of them, and what is left spread between them: five points are too few to tell how a sheet curves.
    kernel = "thin_plate_spline" if known.sum() >= 6 else "linear"
    return RBFInterpolator(points_m[known], values[known], kernel=kernel, degree=1, smoothing=1e-7)(at_m)


def table_z(bundle: Bundle) -> float:
    """Height at which the middle surface of a lying sheet rests, m."""
    table = bundle.environment.table
    return float(table.height_m + 0.5 * bundle.prior.thickness_m.value)
