"""Plain CSV, one row for each marker and frame: `time_s, marker, x, y, z`, a unit in the column names where one likes (`x_mm`)."""

from pathlib import Path

import numpy as np

from sim1.recording.clocks import check_forward_by_marker
from sim1.recording.importing.paths import MarkerPaths, metres_per_unit, numbers, z_up
from sim1.recording.importing.text_table import cell, check_width, numbered, read_cells
from sim1.stage import BadInput


def read_long(path: Path, units: str | None = None, up: str | None = None) -> MarkerPaths:
    """Read a plain CSV; a marker without a row, or with empty coordinates, is in a gap. `up` is "z" where not said.

    Raises:
        BadInput: other columns, a cell that is not a number, a marker whose rows go back in time or that is there twice at one
            time, a unit that nobody says.
    """
    (top, names), *data = numbered(read_cells(path))
    head = [name.lower() for name in names]
    stated = head[2].partition("_")[2] if len(head) == 5 else ""
    axes = [f"{axis}_{stated}" if stated else axis for axis in "xyz"]
    if head != ["time_s", "marker", *axes]:
        raise BadInput(
            f"{path}: row {top}: columns are {names}; expected time_s, marker, x, y, z (or x_mm, y_mm, z_mm)"
        )
    if not data:
        raise BadInput(f"{path}: no rows below the header; export the recording")
    check_width(path, data, len(head))
    factor = metres_per_unit(path, stated or None, units)
    number = np.array([row for row, _ in data])
    values = numbers(path, [[cell(cells, k) for k in (0, 2, 3, 4)] for _, cells in data], number)
    label = [cell(cells, 1) for _, cells in data]
    if (empty := np.isnan(values[:, 0]) | np.array([not name for name in label])).any():
        raise BadInput(f"{path}: row {number[np.argmax(empty)]}: a time or a marker is missing")
    check_forward_by_marker(lambda at: f"{path}: row {number[at]}", values[:, 0], np.array(label))
    time, opens, frame = np.unique(values[:, 0], return_index=True, return_inverse=True)
    labels = tuple(dict.fromkeys(label))
    column = np.array([{name: k for k, name in enumerate(labels)}[name] for name in label])
    _, first, count = np.unique(frame * len(labels) + column, return_index=True, return_counts=True)
    if (count > 1).any():
        at = int(first[np.argmax(count > 1)])
        raise BadInput(f"{path}: row {number[at]}: marker {label[at]!r} occurs twice at {values[at, 0]} s; keep one")
    positions = np.full((len(time), len(labels), 3), np.nan)
    positions[frame, column] = np.where(np.isfinite(values[:, 1:]).all(1, keepdims=True), values[:, 1:], np.nan)
    row_of = np.repeat(number[opens][:, None], len(labels), axis=1)
    row_of[frame, column] = number
    return MarkerPaths(
        file=path,
        time_s=time,
        labels=labels,
        positions_m=z_up(positions * factor, up or "z"),
        rows=row_of,
        counted="row",
    )
