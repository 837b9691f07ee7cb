"""Which cases a proof cannot rest on: those with nothing concealed by which the thresholds in force were chosen."""

from pathlib import Path

from sim1.data_file import read_data_file
from sim1.mismatch.thresholds import FILE, SCHEMA, Measured


def null_seeds(path: Path = FILE) -> frozenset[int]:
    """Seeds of the cases with nothing concealed that a file of thresholds rests on; with anything concealed, a seed films another cloth.

    Raises:
        BadInput: the file is damaged.
    """
    return frozenset(null.seed for null in read_data_file(path, Measured, SCHEMA).nulls)
