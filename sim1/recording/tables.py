"""Parquet tables of a bundle: the columns of the format, of the right kind, none empty."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.stage import BadInput

WHOLE, TRUTH, TEXT = ("marker", "face"), ("visible",), ("drive",)  # the other columns hold numbers


def read_table(path: Path, columns: tuple[str, ...]) -> pd.DataFrame:
    """The table in `path`, rows numbered from 0, columns as plain numpy types.

    Raises:
        BadInput: missing, not Parquet, a column too many or too few, a column of another type, an empty cell, no rows.
    """
    if not path.is_file():
        raise BadInput(f"{path}: missing stream; expected a Parquet table with columns {', '.join(columns)}")
    try:
        table = pd.read_parquet(path)
    except Exception as error:  # damaged Parquet raises many kinds
        raise BadInput(f"{path}: not a readable Parquet table ({' '.join(str(error).split())[:120]})") from error
    check_columns(path, table.columns, columns)
    if table.empty:
        raise BadInput(f"{path}: no rows; record again, or drop the recording")
    table = table.reset_index(drop=True)
    return pd.DataFrame({name: _column(path, name, table[name]) for name in columns})


def check_columns(path: Path, names: Iterable[object], columns: tuple[str, ...]) -> None:
    """Check that a table has just these columns, in any order; `path` is where it came from.

    Raises:
        BadInput: a column too many, too few or twice.
    """
    found = sorted(map(str, names))
    if found != sorted(columns):
        missing, extra = sorted(set(columns) - set(found)), sorted(set(found) - set(columns))
        detail = "; ".join(f"{word} {names}" for word, names in (("missing", missing), ("unknown", extra)) if names)
        raise BadInput(f"{path}: columns are {found}; expected {sorted(columns)} ({detail or 'one occurs twice'})")


def _column(path: Path, name: str, column: pd.Series) -> np.ndarray:
    kind = column.dtype.kind
    if name in TEXT:
        column = column.astype(object)  # also where names were written once each
        wrong = ~column.map(lambda value: isinstance(value, str) and bool(value.strip())).to_numpy(bool)
        if wrong.any():
            row = int(np.argmax(wrong))
            raise BadInput(f"{path}: row {row}: column {name!r} holds {column.iloc[row]!r}, which is not a name")
        return column.to_numpy(object)
    wanted = "b" if name in TRUTH else "iu" if name in WHOLE else "iuf"
    if kind not in wanted:
        meant = "true or false" if name in TRUTH else "whole numbers" if name in WHOLE else "numbers"
        raise BadInput(
            f"{path}: column {name!r} holds {column.dtype}, which is not what the format asks for: {meant}, no cell empty"
        )
    if kind == "f":
        return column.to_numpy(np.float64, na_value=np.nan)
    if (empty := column.isna().to_numpy()).any():
        raise BadInput(f"{path}: row {int(np.argmax(empty))}: column {name!r} is empty; fill it or drop the row")
    return column.to_numpy(bool if kind == "b" else np.int64 if name in WHOLE else np.float64)
