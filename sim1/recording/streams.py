"""Time series of a bundle: anchors, markers and drives as Parquet tables, read into arrays and checked row by row."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.recording.clocks import check_clock, check_origin
from sim1.recording.drive_jumps import check_path
from sim1.recording.tables import read_table
from sim1.stage import BadInput

ANCHOR_COLUMNS = ("marker", "face", "b0", "b1", "b2")
MARKER_COLUMNS = ("time_s", "marker", "x_m", "y_m", "z_m", "visible")
DRIVE_COLUMNS = ("time_s", "drive", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "open")
LARGEST_ID = 2**31 - 1  # ids are written as 32-bit numbers
FARTHEST_M = 100.0  # from the origin: farther off is another unit


@dataclass(frozen=True, kw_only=True)
class Anchors:
    """Where each of M markers sits on the mesh."""

    marker: np.ndarray  # (M,) ids, ascending
    face: np.ndarray  # (M,)
    weight: np.ndarray  # (M, 3) barycentric coordinates


@dataclass(frozen=True, kw_only=True)
class Track:
    """Commanded path of one drive, D samples."""

    time_s: np.ndarray  # (D,)
    position_m: np.ndarray  # (D, 3)
    rotation_wxyz: np.ndarray  # (D, 4) unit, signs continuous
    openness: np.ndarray  # (D,) in [0, 1]


def _row(mask: np.ndarray) -> int:
    return int(np.argmax(mask))


def read_anchors(path: Path, face_count: int) -> Anchors:
    """Read `anchors.parquet`.

    Raises:
        BadInput: a face that the mesh does not have, coordinates that do not sum to 1 or lie outside the face, a repeated marker.
    """
    table = read_table(path, ANCHOR_COLUMNS).sort_values("marker", kind="stable")
    marker, face = table["marker"].to_numpy(np.int64), table["face"].to_numpy(np.int64)
    weight = table[["b0", "b1", "b2"]].to_numpy(float)
    rows = table.index.to_numpy()
    if (again := np.diff(marker) == 0).any():
        raise BadInput(f"{path}: row {rows[1:][again][0]}: marker {marker[1:][again][0]} has two anchors")
    if (odd := (marker < 0) | (marker > LARGEST_ID)).any():
        raise BadInput(f"{path}: row {rows[_row(odd)]}: marker id {marker[_row(odd)]}; ids run from 0 to {LARGEST_ID}")
    if (off := (face < 0) | (face >= face_count)).any():
        raise BadInput(f"{path}: row {rows[_row(off)]}: marker off the mesh: face {face[_row(off)]} of {face_count}")
    if (out := ~((weight > -1e-6) & (weight < 1 + 1e-4)).all(1)).any():
        raise BadInput(
            f"{path}: row {rows[_row(out)]}: marker off the mesh: barycentric {weight[_row(out)].tolist()} lies outside its face "
            "(each from 0 to 1)"
        )
    total = weight.sum(1)
    if (bad := np.abs(total - 1) > 1e-4).any():
        raise BadInput(
            f"{path}: row {rows[_row(bad)]}: b0 + b1 + b2 is {total[_row(bad)]:.6g}; barycentric coordinates sum to 1"
        )
    return Anchors(marker=marker, face=face, weight=weight)


def read_markers(path: Path, marker: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Read `markers.parquet` as times (T,) and positions (T, M, 3), NaN where a marker was not seen.

    Raises:
        BadInput: a clock that stands or runs backwards, NaN where visible, unknown or missing markers, nothing visible.
    """
    table = read_table(path, MARKER_COLUMNS)
    time, ids = table["time_s"].to_numpy(float), table["marker"].to_numpy(np.int64)
    place, seen = table[["x_m", "y_m", "z_m"]].to_numpy(float), table["visible"].to_numpy(bool)
    check_origin(str(path), time, lambda at: at)
    frames, first, frame = np.unique(time, return_index=True, return_inverse=True)
    _check_order(path, time, ids)
    check_clock(str(path), frames, lambda at: int(first[at]))
    if (unknown := ~np.isin(ids, marker)).any():
        raise BadInput(
            f"{path}: row {_row(unknown)}: marker {ids[_row(unknown)]} has no anchor; add it to anchors.parquet or drop it"
        )
    if (hidden := seen & ~np.isfinite(place).all(1)).any():
        raise BadInput(
            f"{path}: row {_row(hidden)}: marker {ids[_row(hidden)]} is visible and its place {place[_row(hidden)]}; set visible=false"
        )
    if (far := seen & (np.abs(place) > FARTHEST_M).any(1)).any():
        raise BadInput(
            f"{path}: row {_row(far)}: marker {ids[_row(far)]} is at {place[_row(far)].tolist()}; expected metres: are these millimetres?"
        )
    if not seen.any():
        raise BadInput(f"{path}: no marker is visible in any of {len(table)} rows; nothing can be compared")
    column = np.searchsorted(marker, ids)
    count = np.zeros((len(frames), len(marker)), int)
    np.add.at(count, (frame, column), 1)
    if (count != 1).any():
        f, m = np.argwhere(count != 1)[0]
        raise BadInput(
            f"{path}: row {_row(frame == f)}: frame at {frames[f]} s has {count[f, m]} rows of marker {marker[m]}; "
            "one row per marker and frame (visible=false where it was not seen), and no time stamp twice"
        )
    if len(frames) < 3:
        raise BadInput(f"{path}: {len(frames)} frames; a recording needs 3 or more")
    positions = np.full((len(frames), len(marker), 3), np.nan)
    positions[frame[seen], column[seen]] = place[seen]
    return frames, positions


def _check_order(path: Path, time_s: np.ndarray, ids: np.ndarray) -> None:
    """Check that the rows of each marker follow its time: frame by frame or marker by marker, a clock that ran back is seen.

    Raises:
        BadInput: rows of a marker that go back in time.
    """
    rows = np.argsort(ids, kind="stable")
    back = (np.diff(ids[rows]) == 0) & (np.diff(time_s[rows]) < 0)
    if back.any():
        before, after = (rows[int(np.argmax(back)) + k] for k in (0, 1))
        raise BadInput(
            f"{path}: row {after}: the clock runs back from {time_s[before]} s to {time_s[after]} s for marker {ids[after]}; "
            "sort or repair the time stamps"
        )


def read_drives(path: Path) -> dict[str, Track]:
    """Read `drives.parquet`: one track per drive.

    Raises:
        BadInput: a clock that stands or runs backwards, NaN, a quaternion that is not unit, openness outside [0, 1], a jump.
    """
    table = read_table(path, DRIVE_COLUMNS)
    tracks = drives_of(path, table)
    check_origin(str(path), table["time_s"].to_numpy(float), lambda at: at)
    return tracks


def drives_of(path: Path, table: pd.DataFrame) -> dict[str, Track]:
    """Tracks by name of a table with `DRIVE_COLUMNS`, rows numbered from 0; `path` is where it came from.

    Raises:
        BadInput: as `read_drives`, but for the clock's origin, which an import may shift.
    """
    return {str(name): _track(path, str(name), part) for name, part in table.groupby("drive", sort=True)}


def _track(path: Path, name: str, part: pd.DataFrame) -> Track:
    rows = part.index.to_numpy()
    values = part[[column for column in DRIVE_COLUMNS if column != "drive"]].to_numpy(float)
    if (bad := ~np.isfinite(values).all(1)).any():
        raise BadInput(
            f"{path}: row {rows[_row(bad)]}: drive {name!r} has a value that is not finite; a command is always known"
        )
    time, position, rotation, openness = values[:, 0], values[:, 1:4], values[:, 4:8], values[:, 8]
    if (far := (np.abs(position) > FARTHEST_M).any(1)).any():
        raise BadInput(
            f"{path}: row {rows[_row(far)]}: drive {name!r} is at {position[_row(far)].tolist()} at {time[_row(far)]} s; "
            "expected metres: are these millimetres?"
        )
    if len(time) < 2:
        raise BadInput(f"{path}: drive {name!r} has {len(time)} sample; a path needs 2 or more")
    check_clock(f"{path}: drive {name!r}", time, lambda at: int(rows[at]))
    length = np.linalg.norm(np.clip(rotation, -9, 9), axis=1)  # clipped: a square must not overflow
    if (bad := np.abs(length - 1) > 1e-2).any():
        raise BadInput(
            f"{path}: row {rows[_row(bad)]}: quaternion of drive {name!r} has length {length[_row(bad)]:.4g}; expected 1 (qw, qx, qy, qz)"
        )
    if (bad := (openness < 0) | (openness > 1)).any():
        raise BadInput(f"{path}: row {rows[_row(bad)]}: open is {openness[_row(bad)]}; expected 0 (closed) to 1")
    rotation = np.where(np.abs(length - 1)[:, None] > 1e-9, rotation / length[:, None], rotation)
    flips = np.where((rotation[1:] * rotation[:-1]).sum(1) < 0, -1.0, 1.0)
    rotation = rotation * np.concatenate([[1.0], np.cumprod(flips)])[:, None]
    check_path(f"{path}: drive {name!r}", time, position, rotation, lambda at: int(rows[at]))
    return Track(time_s=time, position_m=position, rotation_wxyz=rotation, openness=openness)


def write_anchors(path: Path, anchors: Anchors) -> None:
    """Write `anchors.parquet`."""
    columns = {"marker": anchors.marker.astype(np.int32), "face": anchors.face.astype(np.int32)}
    columns |= {f"b{k}": anchors.weight[:, k] for k in range(3)}
    pd.DataFrame(columns).to_parquet(path, index=False)


def write_markers(path: Path, marker: np.ndarray, time_s: np.ndarray, positions_m: np.ndarray) -> None:
    """Write `markers.parquet`; NaN positions are written as not visible."""
    flat = positions_m.reshape(-1, 3)
    seen = np.isfinite(flat).all(1)
    flat = np.where(seen[:, None], flat, np.nan)
    columns = {"time_s": np.repeat(time_s, len(marker)), "marker": np.tile(marker.astype(np.int32), len(time_s))}
    columns |= {name: flat[:, k].astype(np.float32) for k, name in enumerate(("x_m", "y_m", "z_m"))}
    pd.DataFrame(columns | {"visible": seen}).to_parquet(path, index=False)


def write_drives(path: Path, drives: dict[str, Track]) -> None:
    """Write `drives.parquet`, drives one after the other in order of name."""
    parts = []
    for name in sorted(drives):
        track = drives[name]
        columns: dict[str, object] = {"time_s": track.time_s, "drive": [name] * len(track.time_s)}
        columns |= {axis: track.position_m[:, k] for k, axis in enumerate(("x_m", "y_m", "z_m"))}
        columns |= {axis: track.rotation_wxyz[:, k] for k, axis in enumerate(("qw", "qx", "qy", "qz"))}
        parts.append(pd.DataFrame(columns | {"open": track.openness}))
    pd.concat(parts).to_parquet(path, index=False)
