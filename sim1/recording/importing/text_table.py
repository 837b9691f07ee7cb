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


def numbered(rows: list[list[str]], start: int = 0) -> list[tuple[int, list[str]]]:
    """The rows from index `start` on that are not blank, each with its number in the file, from 1."""
    return [(k + 1, row) for k, row in enumerate(rows) if row and k >= start]


def check_width(path: Path, data: list[tuple[int, list[str]]], count: int) -> None:
    """Check that no numbered row has more cells than the header (`count`), as one of numbers with decimal commas has.

    Raises:
        BadInput: one has.
    """
    for row, cells in data:
        if len(cells) > count:
            raise BadInput(f"{path}: row {row}: {len(cells)} cells for {count} columns; write numbers with a point")


def triples(path: Path, data: list[tuple[int, list[str]]], columns: list[int]) -> np.ndarray:
    """Numbers (n, k / 3, 3) in the given columns of numbered rows; a marker without all three is in a gap."""
    text = [[cell(row, column) for column in columns] for _, row in data]
    values = numbers(path, text, [row for row, _ in data]).reshape(len(data), -1, 3)
    return np.where(np.isfinite(values).all(-1, keepdims=True), values, np.nan)
