"""Where the cloth sits in its grips, estimated where nobody measured it."""

import warnings

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.cloth.precise.drives import drive_pose
from sim1.cloth.precise.material import marker_points, sheet_of
from sim1.cloth.precise.start import resting_shape
from sim1.recording.bundle import Bundle, Hold
from sim1.recording.motion import rest_until_s
from sim1.stage import BadInput


def hold_key(hold: Hold) -> tuple[str, tuple[int, ...]]:
    """What holds of several recordings share when their places are the same unknown."""
    return hold.drive, tuple(int(v) for v in hold.vertices)


def hold_keys(bundle: Bundle) -> list[tuple[str, tuple[int, ...]]]:
    """Grips of the bundle, in the order of a world's `places`."""
    return sorted({hold_key(hold) for recording in bundle.recordings for hold in recording.holds})


def estimated_places(bundle: Bundle) -> dict[tuple[str, tuple[int, ...]], np.ndarray]:
    """Places (h, 3) of each grip's vertices in its drive's frame, m: as measured, else the flat patch fitted to the resting markers.

    Raises:
        BadInput: places that nobody measured, and no recording starts at rest in that grip with enough markers to be seen.
    """
    sheet, points = sheet_of(bundle), marker_points(bundle)
    holds = [(recording, hold) for recording in bundle.recordings for hold in recording.holds]
    measured = {hold_key(hold): hold.places_m for _, hold in holds if hold.places_m is not None}
    estimates: dict[tuple[str, tuple[int, ...]], list[np.ndarray]] = {}
    for recording, hold in holds:
        if hold_key(hold) in measured or recording.starts != "rest":
            continue
        if hold.from_s > rest_until_s(recording) + 0.05:  # taken up later: the resting markers do not show it
            continue
        seen = resting_shape(recording, points, sheet)[hold.vertices]
        position, turn = drive_pose(recording.drives[hold.drive], np.array([recording.time_s[0]]))
        local = (seen - position[0]) @ turn[0]
        flat = np.column_stack([sheet.material_m[hold.vertices], np.zeros(len(hold.vertices))])
        if len(flat) > 1:
            with warnings.catch_warnings():  # vertices on one line leave the turn about it open: any will do
                warnings.simplefilter("ignore", UserWarning)
                rotation, _ = Rotation.align_vectors(local - local.mean(0), flat - flat.mean(0))
            local = rotation.apply(flat - flat.mean(0)) + local.mean(0)
        estimates.setdefault(hold_key(hold), []).append(local)
    for recording, hold in holds:
        if hold_key(hold) not in measured | estimates:
            raise BadInput(
                f"bundle.yaml: recording {recording.name}: places_m of drive {hold.drive!r} is null and no recording starts at rest "
                "in this grip; measure where the cloth sits in it"
            )
    return measured | {key: np.mean(parts, axis=0) for key, parts in estimates.items()}
