"""Time series of a bundle: anchors, markers and drives as Parquet tables, read into arrays and checked row by row."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.recording.clocks import check_clock, check_forward_by_marker, check_origin
from sim1.recording.drive_jumps import check_path
from sim1.recording.places import Places
from sim1.recording.tables import read_table
from sim1.stage import BadInput

ANCHOR_COLUMNS = ("marker", "face", "b0", "b1", "b2")
MARKER_COLUMNS = ("time_s", "marker", "x_m", "y_m", "z_m", "visible")
DRIVE_COLUMNS = ("time_s", "drive", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "open")
LARGEST_ID = 2**31 - 1  # ids are written as 32-bit numbers
VALUE_COLUMNS = tuple(column for column in DRIVE_COLUMNS if column != "drive")
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


@dataclass(frozen=True, kw_only=True)
class Drives:
    """All drives of one recording, and where their samples stand."""

    tracks: dict[str, Track]
    rows: dict[str, np.ndarray]  # (D,) of the table, a track each
    places: Places

    def place(self, drive: str, sample: int) -> str:
        """Where a sample of a drive stands."""
        return self.places.row(int(self.rows[drive][sample]))


@dataclass(frozen=True, kw_only=True)
class Seen:
    """Markers of one recording, T frames of M markers, and where they stand."""

    marker: np.ndarray  # (M,) ids
    time_s: np.ndarray  # (T,)
    markers_m: np.ndarray  # (T, M, 3), NaN where not seen
    rows: np.ndarray  # (T, M) of the table
    places: Places

    def place(self, frame: int, column: int | None = None) -> str:
        """Where a marker of a frame stands, or the frame's first row."""
        return self.places.row(int(self.rows[frame].min() if column is None else self.rows[frame, column]))


def _row(mask: np.ndarray) -> int:
    return int(np.argmax(mask))


def read_anchors(path: Path, face_count: int, places: Places) -> Anchors:
    """Read `anchors.parquet`; messages name `places`.

    Raises:
        BadInput: a face that the mesh does not have, coordinates that do not sum to 1 or lie outside the face, a repeated marker.
    """
    table = read_table(path, ANCHOR_COLUMNS).sort_values("marker", kind="stable")
    marker, face = table["marker"].to_numpy(np.int64), table["face"].to_numpy(np.int64)
    weight = table[["b0", "b1", "b2"]].to_numpy(float)
    rows = table.index.to_numpy()

    def place(wrong: np.ndarray) -> str:
        return places.row(int(rows[_row(wrong)]))

    if (again := np.concatenate([[False], marker[1:] == marker[:-1]])).any():
        raise BadInput(f"{place(again)}: marker {marker[_row(again)]} has two anchors; keep one")
    if (odd := (marker < 0) | (marker > LARGEST_ID)).any():
        raise BadInput(f"{place(odd)}: marker id {marker[_row(odd)]}; ids run from 0 to {LARGEST_ID}")
    if (off := (face < 0) | (face >= face_count)).any():
        raise BadInput(f"{place(off)}: marker off the mesh: face {face[_row(off)]} of {face_count}; faces count from 0")
    if (out := ~((weight > -1e-6) & (weight < 1 + 1e-4)).all(1)).any():
        raise BadInput(
            f"{place(out)}: marker off the mesh: barycentric {weight[_row(out)].tolist()} lies outside its face "
            "(each from 0 to 1)"
        )
    total = weight.sum(1)
    if (bad := np.abs(total - 1) > 1e-4).any():
        raise BadInput(f"{place(bad)}: b0 + b1 + b2 is {total[_row(bad)]:.6g}; barycentric coordinates sum to 1")
    return Anchors(marker=marker, face=face, weight=weight)


def read_markers(path: Path, marker: np.ndarray, places: Places) -> Seen:
    """Read `markers.parquet`, markers in the order of the ids `marker` (M,); messages name `places`.

    Raises:
        BadInput: a clock that stands or runs backwards, NaN where visible, unknown or missing markers, nothing visible.
    """
    table = read_table(path, MARKER_COLUMNS)
    time, ids = table["time_s"].to_numpy(float), table["marker"].to_numpy(np.int64)
    position, seen = table[["x_m", "y_m", "z_m"]].to_numpy(float), table["visible"].to_numpy(bool)
    check_origin(places.row, time)
    frames, first, frame = np.unique(time, return_index=True, return_inverse=True)
    check_forward_by_marker(places.row, time, ids)
    check_clock(lambda at: places.row(int(first[at])), frames)
    if (unknown := ~np.isin(ids, marker)).any():
        at = _row(unknown)
        raise BadInput(f"{places.row(at)}: marker {ids[at]} has no anchor; add it to anchors.parquet or drop it")
    if (hidden := seen & ~np.isfinite(position).all(1)).any():
        at = _row(hidden)
        raise BadInput(f"{places.row(at)}: marker {ids[at]} is visible and its place {position[at]}; set visible=false")
    if (far := seen & (np.abs(position) > FARTHEST_M).any(1)).any():
        at = _row(far)
        raise BadInput(
            f"{places.row(at)}: marker {ids[at]} is at {position[at].tolist()}; expected metres: are these millimetres?"
        )
    if not seen.any():
        raise BadInput(f"{places.file}: no marker is visible in any of {len(frames)} frames; nothing can be compared")
    column = np.searchsorted(marker, ids)
    count = np.zeros((len(frames), len(marker)), int)
    np.add.at(count, (frame, column), 1)
    if (count != 1).any():
        f, m = np.argwhere(count != 1)[0]
        raise BadInput(
            f"{places.row(_row(frame == f))}: frame at {frames[f]} s has {count[f, m]} rows of marker {marker[m]}; "
            "one row per marker and frame (visible=false where it was not seen), and no time stamp twice"
        )
    if len(frames) < 3:
        raise BadInput(f"{places.file}: {len(frames)} frames; a recording needs 3 or more")
    positions, rows = np.full((len(frames), len(marker), 3), np.nan), np.zeros((len(frames), len(marker)), int)
    positions[frame[seen], column[seen]] = position[seen]
    rows[frame, column] = np.arange(len(table))
    return Seen(marker=marker, time_s=frames, markers_m=positions, rows=rows, places=places)


def read_drives(path: Path, places: Places) -> Drives:
    """Read `drives.parquet`: one track per drive; messages name `places`.

    Raises:
        BadInput: a clock that stands or runs backwards, NaN, a quaternion that is not unit, openness outside [0, 1], a jump.
    """
    table = read_table(path, DRIVE_COLUMNS)
    drives = drives_of(places, table)
    check_origin(places.row, table["time_s"].to_numpy(float))
    return drives


def drives_of(places: Places, table: pd.DataFrame) -> Drives:
    """Drives of a table with `DRIVE_COLUMNS`, whose index holds the rows that `places` knows.

    Raises:
        BadInput: as `read_drives`, but for the clock's origin, which an import may shift.
    """
    parts = {str(name): part for name, part in table.groupby("drive", sort=True)}
    rows = {name: part.index.to_numpy() for name, part in parts.items()}
    tracks = {name: _track(places, name, part) for name, part in parts.items()}
    return Drives(tracks=tracks, rows=rows, places=places)


def _track(places: Places, name: str, part: pd.DataFrame) -> Track:
    rows, values = part.index.to_numpy(), part[list(VALUE_COLUMNS)].to_numpy(float)

    def place(sample: int) -> str:
        return f"{places.row(int(rows[sample]))}: drive {name!r}"

    if (bad := ~np.isfinite(values)).any():
        sample, column = np.argwhere(bad)[0]
        raise BadInput(
            f"{place(sample)}: {VALUE_COLUMNS[column]} is {values[sample, column]}, which is not finite; a command is always known"
        )
    time, position, rotation, openness = values[:, 0], values[:, 1:4], values[:, 4:8], values[:, 8]
    if (far := (np.abs(position) > FARTHEST_M).any(1)).any():
        at = _row(far)
        raise BadInput(
            f"{place(at)} is at {position[at].tolist()} at {time[at]} s; expected metres: are these millimetres?"
        )
    if len(time) < 2:
        raise BadInput(f"{places.file}: drive {name!r} has {len(time)} sample; a path needs 2 or more")
    check_clock(place, time)
    length = np.linalg.norm(np.clip(rotation, -9, 9), axis=1)  # clipped: a square must not overflow
    if (bad := np.abs(length - 1) > 1e-2).any():
        at = _row(bad)
        raise BadInput(f"{place(at)}: its quaternion has length {length[at]:.4g}; expected 1 (qw, qx, qy, qz)")
    if (bad := (openness < 0) | (openness > 1)).any():
        at = _row(bad)
        raise BadInput(f"{place(at)}: open is {openness[at]}; expected 0 (closed) to 1")
    rotation = np.where(np.abs(length - 1)[:, None] > 1e-9, rotation / length[:, None], rotation)
    flips = np.where((rotation[1:] * rotation[:-1]).sum(1) < 0, -1.0, 1.0)
    rotation = rotation * np.concatenate([[1.0], np.cumprod(flips)])[:, None]
    check_path(place, time, position, rotation)
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
