"""Drives of a recording from a table in text."""

from pathlib import Path

import pandas as pd

from sim1.recording.importing.paths import numbers
from sim1.recording.importing.text_table import cell, check_width, numbered, read_cells
from sim1.recording.places import own_places
from sim1.recording.streams import DRIVE_COLUMNS, VALUE_COLUMNS, Drives, drives_of
from sim1.recording.tables import check_columns, read_table
from sim1.stage import BadInput


def read_drive_table(path: Path) -> Drives:
    """Read a CSV (or Parquet) table with the columns of `drives.parquet`, metres, z up. Rows of text count from 1, others from 0.

    Raises:
        BadInput: missing, other columns, a cell that is not a number, a damaged path.
    """
    table = read_table(path, DRIVE_COLUMNS) if path.suffix == ".parquet" else _from_text(path)
    return drives_of(own_places(path), table)


def _from_text(path: Path) -> pd.DataFrame:
    """The table, whose index holds the rows of the file."""
    (_, head), *data = numbered(read_cells(path))
    check_columns(path, head, DRIVE_COLUMNS)
    if not data:
        raise BadInput(f"{path}: no rows below the header; export the drives")
    check_width(path, data, len(head))
    for row, cells in data:
        if not cell(cells, head.index("drive")):
            raise BadInput(f"{path}: row {row}: no drive; name the one that the command is for")
    text = [[cell(cells, head.index(name)) for name in VALUE_COLUMNS] for _, cells in data]
    rows = [row for row, _ in data]
    values = numbers(path, text, rows, "a command is always known")
    names = [cell(cells, head.index("drive")) for _, cells in data]
    return pd.DataFrame(values, columns=list(VALUE_COLUMNS), index=rows).assign(drive=names)
