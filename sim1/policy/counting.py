"""Counts that reports of several stages need."""

from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from sim1.stage import BadInput

_DECISION = ("accepted", "success", "perturbed")


def read_table(path: Path) -> pd.DataFrame:
    """A parquet table of an artifact.

    Raises:
        BadInput: missing or damaged.
    """
    try:
        return pd.read_parquet(path)
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: not a readable table ({error}); make the artifact again") from error


def read_decisions(artifacts: Mapping[str, Path]) -> pd.DataFrame:
    """Decisions of all garments' `valid_trajectories`, one row per candidate.

    Raises:
        BadInput: a table is missing, damaged, or lacks one of the columns `_DECISION`.
    """
    tables = []
    for garment, folder in sorted(artifacts.items()):
        table = read_table(folder / "decisions.parquet")
        missing = set(_DECISION) - set(table.columns)
        if missing:
            raise BadInput(f"{folder}/decisions.parquet: no column {', '.join(sorted(missing))}; make it again")
        tables.append(table[list(_DECISION)].astype(bool).assign(garment=garment))
    return pd.concat(tables, ignore_index=True)


def accepted_count(artifacts: Mapping[str, Path]) -> int:
    """Accepted trajectories of all garments."""
    return int(read_decisions(artifacts)["accepted"].sum())
