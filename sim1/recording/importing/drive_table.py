"""Drives of a recording from a table in text."""

from pathlib import Path

import pandas as pd

from sim1.recording.streams import DRIVE_COLUMNS, Track, drives_of
from sim1.recording.tables import checked_table, read_table
from sim1.stage import BadInput


def read_drive_table(path: Path) -> dict[str, Track]:
    """Read a CSV (or Parquet) table with the columns of `drives.parquet`, metres, z up.

    Raises:
        BadInput: missing, other columns, a damaged path.
    """
    if path.suffix == ".parquet":
        return drives_of(path, read_table(path, DRIVE_COLUMNS))
    try:
        table = pd.read_csv(path, skipinitialspace=True, encoding="utf-8-sig", dtype={"drive": str})
    except (OSError, ValueError) as error:  # a parser's error is a ValueError
        raise BadInput(
            f"{path}: not readable as CSV ({' '.join(str(error).split())[:120]}); expected {DRIVE_COLUMNS}"
        ) from error
    return drives_of(path, checked_table(path, table, DRIVE_COLUMNS))
