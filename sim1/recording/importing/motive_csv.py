"""OptiTrack Motive's CSV export: one row of settings, rows of type, name, ID and component, then a row for each frame.

Markers are read as measured (`Marker`), or as the rigid body predicts them where only that was exported; rotations, bodies and
bones are left out. Motive's own axes have y up.
"""

from pathlib import Path

import numpy as np

from sim1.recording.importing.paths import MarkerPaths, metres_per_unit, numbers, z_up
from sim1.recording.importing.text_table import cell, numbered, read_cells, triples
from sim1.stage import BadInput

KINDS = (
    "marker",
    "rigid body marker",
    "bone marker",
    "markerset marker",
)  # the first is preferred where a name has several


def read_motive(path: Path, units: str | None = None, up: str | None = None) -> MarkerPaths:
    """Read a Motive CSV export; `up` is "y" where not said.

    Raises:
        BadInput: no such header, no markers, a cell that is not a number, a unit that nobody says.
    """
    rows = read_cells(path)
    axes = next((k for k, row in enumerate(rows) if cell(row, 0) == "Frame" and cell(row, 1).startswith("Time")), None)
    if axes is None or axes < 3:
        raise BadInput(
            f"{path}: no row 'Frame, Time (Seconds), X, Y, Z, ...'; is it a CSV export of Motive, with its header?"
        )
    header = [row for row in rows[1:axes] if row]
    named = {cell(row, 1): row for row in header if cell(row, 1)}
    kinds, names = named.get("Type", header[0]), named.get("Name", header[min(1, len(header) - 1)])
    columns = _columns(kinds, names, header[-1], rows[axes])
    if not columns:
        raise BadInput(f"{path}: no column of type Marker with X, Y, Z positions; export markers from Motive")
    data = numbered(rows, axes + 1)
    if not data:
        raise BadInput(f"{path}: no frame below the header in row {axes + 1}; export the whole take")
    settings = dict(zip(rows[0][::2], rows[0][1::2]))
    if (promised := settings.get("Total Exported Frames", "")).isdecimal() and int(promised) > len(data):
        raise BadInput(
            f"{path}: the header promises {promised} frames, the file holds {len(data)}; it was cut short: copy it again"
        )
    factor = metres_per_unit(path, settings.get("Length Units"), units)
    number = np.array([row for row, _ in data])
    time = numbers(path, [[cell(row, 1)] for _, row in data], number)[:, 0]
    if (empty := np.isnan(time)).any():
        raise BadInput(f"{path}: row {number[np.argmax(empty)]}: no time; export it again")
    positions = triples(path, data, [column for _, three in columns for column in three])
    return MarkerPaths(
        file=path,
        time_s=time,
        labels=tuple(name for name, _ in columns),
        positions_m=z_up(positions * factor, up or "y"),
        rows=np.broadcast_to(number[:, None], positions.shape[:2]),
        counted="row",
    )


def _columns(kinds: list[str], names: list[str], parts: list[str], axes: list[str]) -> list[tuple[str, list[int]]]:
    """Label and the columns of its x, y, z, in the order of the file."""
    found: dict[tuple[str, int], list[tuple[int, list[int]]]] = {}
    column = 2
    while column + 2 < len(axes):
        kind = cell(kinds, column).lower()
        if (
            kind in KINDS
            and axes[column : column + 3] == ["X", "Y", "Z"]
            and cell(parts, column).startswith("Position")
        ):
            found.setdefault((cell(names, column), KINDS.index(kind)), []).append(
                (column, [column, column + 1, column + 2])
            )
            column += 3
        else:
            column += 1
    best = {name: min(rank for other, rank in found if other == name) for name, _ in found}
    chosen = [
        (place, name, three) for (name, rank), many in found.items() for place, three in many if rank == best[name]
    ]
    return [(name, three) for _, name, three in sorted(chosen)]
