"""Lines of a CSV file as cells, whatever the system that exported it put before and after."""

import csv
from pathlib import Path

import numpy as np

from sim1.recording.importing.paths import numbers
from sim1.stage import BadInput


def read_cells(path: Path) -> list[list[str]]:
    """All rows of a CSV file, cells stripped; a blank line is an empty row.

    Raises:
        BadInput: missing, not text, empty.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = [[cell.strip() for cell in row] for row in csv.reader(stream)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise BadInput(f"{path}: not readable as CSV ({error}); export it again as comma-separated text") from error
    rows = [row if any(row) else [] for row in rows]
    if not any(rows):
        raise BadInput(f"{path}: the file is empty; export it again")
    return rows


def cell(row: list[str], column: int) -> str:
    """A cell, or nothing where the row is shorter: exports leave out empty cells at the end."""
    return row[column] if column < len(row) else ""


def triples(path: Path, rows: list[list[str]], first_row: int, columns: list[int]) -> np.ndarray:
    """Numbers (n, k / 3, 3) in the given columns of data rows; a marker without all three is in a gap."""
    text = [[cell(row, column) for column in columns] for row in rows]
    values = numbers(path, text, range(first_row, first_row + len(rows))).reshape(len(rows), -1, 3)
    return np.where(np.isfinite(values).all(-1, keepdims=True), values, np.nan)
