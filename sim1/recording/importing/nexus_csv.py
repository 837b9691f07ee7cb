"""Vicon Nexus' CSV export: the section `Trajectories` with rate, labels, axes and units; other sections are left out."""

from pathlib import Path

import numpy as np

from sim1.recording.importing.paths import MarkerPaths, metres_per_unit, numbers, z_up
from sim1.recording.importing.text_table import cell, numbered, read_cells, triples
from sim1.stage import BadInput


def read_nexus(path: Path, units: str | None = None, up: str | None = None) -> MarkerPaths:
    """Read the trajectories of a Nexus CSV export; `up` is "z" where not said. Frame 1 is at 0 s, also in a cropped trial.

    Raises:
        BadInput: no such section, no rate, no markers, a cell that is not a number, units that differ or that nobody says.
    """
    rows = read_cells(path)
    start = next((k for k, row in enumerate(rows) if cell(row, 0) == "Trajectories"), None)
    if start is None or len(rows) < start + 6:
        raise BadInput(f"{path}: no section 'Trajectories' with data; export trajectories from Nexus as CSV (ASCII)")
    rate, names, axes, unit_row = (rows[start + k] for k in (1, 2, 3, 4))
    hertz = float(numbers(path, [[cell(rate, 0)]], [start + 2])[0, 0])
    if not hertz > 0:
        raise BadInput(f"{path}: row {start + 2}: frame rate {cell(rate, 0)!r}; expected a number of Hz above 0")
    if cell(axes, 0) != "Frame":
        raise BadInput(f"{path}: row {start + 4}: expected 'Frame, Sub Frame, X, Y, Z, ...', found {axes[:5]}")
    columns = [c for c in range(2, len(axes) - 2) if axes[c : c + 3] == ["X", "Y", "Z"] and cell(names, c)]
    if not columns:
        raise BadInput(f"{path}: row {start + 3}: no label above an X, Y, Z; export labelled trajectories")
    stated = {cell(unit_row, column + axis) for column in columns for axis in range(3)} - {""}
    if len(stated) > 1:
        raise BadInput(f"{path}: row {start + 5}: units of length differ: {sorted(stated)}; export again")
    end = next((k for k in range(start + 5, len(rows)) if not rows[k]), len(rows))
    data = numbered(rows[:end], start + 5)
    if not data:
        raise BadInput(f"{path}: row {start + 6}: no frame; export the whole trial")
    number = np.array([row for row, _ in data])
    frame = numbers(path, [[cell(row, 0)] for _, row in data], number)[:, 0]
    if np.isnan(frame).any():
        raise BadInput(f"{path}: row {number[np.argmax(np.isnan(frame))]}: no frame number; export it again")
    positions = triples(path, data, [column + axis for column in columns for axis in range(3)])
    factor = metres_per_unit(path, next(iter(stated), None), units)
    return MarkerPaths(
        file=path,
        time_s=(frame - 1) / hertz,
        labels=tuple(names[column] for column in columns),
        positions_m=z_up(positions * factor, up or "z"),
        rows=np.broadcast_to(number[:, None], positions.shape[:2]),
        counted="row",
    )
