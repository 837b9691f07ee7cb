"""Counts that reports of several stages need."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pydantic

from sim1.clustered_share import Difference
from sim1.data_file import explained
from sim1.stage import BadInput
from sim1.statistics import Interval, wilson_interval

NOT_RUN = "not run"
_DECISION = ("accepted", "success", "perturbed")


def read_table(path: Path, columns: Sequence[str] = ()) -> pd.DataFrame:
    """A parquet table of an artifact, with at least these columns.

    Raises:
        BadInput: missing or damaged, or a column is missing.
    """
    try:
        table = pd.read_parquet(path)
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: not a readable table ({error}); make the artifact again") from error
    if missing := [name for name in columns if name not in table.columns]:
        raise BadInput(f"{path}: no column {', '.join(missing)}; make the artifact again")
    return table


def read_figures(path: Path, schema: str, stage: str, content: type = dict) -> dict[str, Any]:
    """What a report wrote as JSON; `content` is a TypedDict of what is read of it.

    Raises:
        BadInput: missing, damaged, of another version, or without what is read of it.
    """
    try:
        found = json.loads(path.read_text())
        version = found["schema"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: not readable ({error}); make {stage} again") from error
    if version != schema:
        raise BadInput(f"{path}: schema is {version!r}, expected {schema!r}; make {stage} again")
    try:
        pydantic.TypeAdapter(content).validate_python(found)
    except pydantic.ValidationError as error:
        raise BadInput(f"{path}: {explained(error)}; make {stage} again") from error
    return found


def read_decisions(artifacts: Mapping[str, Path]) -> pd.DataFrame:
    """Decisions of all garments' `valid_trajectories`, one row per candidate.

    Raises:
        BadInput: a table is missing, damaged, or lacks one of the columns `_DECISION`.
    """
    tables = []
    for garment, folder in sorted(artifacts.items()):
        table = read_table(folder / "decisions.parquet", _DECISION)
        tables.append(table[list(_DECISION)].astype(bool).assign(garment=garment))
    return pd.concat(tables, ignore_index=True)


def rate(count: int, total: int, interval: Interval | None = None) -> str:
    """A share in percent as a cell of a table: "42 (32 to 53), 36 of 85"; without an interval of its own, with Wilson's."""
    if not total:
        return NOT_RUN
    low, high = interval or wilson_interval(count, total)
    return f"{together(f'{100 * count / total:.0f} ({100 * low:.0f} to {100 * high:.0f}),')} {together(f'{count} of {total}')}"


def percentage_points(difference: Difference | None) -> str:
    """A difference in percentage points as a cell of a table: "+33 (+8 to +53), 30 pairs"."""
    if difference is None:
        return NOT_RUN
    low, high = (f"{100 * limit:+.0f}" for limit in difference.interval)
    pairs = "1 pair" if difference.pair_count == 1 else f"{difference.pair_count} pairs"
    return f"{together(f'{100 * difference.value:+.0f} ({low} to {high}),')} {together(pairs)}"


def together(words: str) -> str:
    """The same, not to be broken where a column is narrow."""
    return words.replace(" ", "\N{NO-BREAK SPACE}")


def shown_count(dataset: Path) -> int:
    """Trajectories of all garments that a `dataset` artifact shows, each once, in however many appearances.

    Raises:
        BadInput: its provenance is missing or damaged.
    """
    names = ["garment", "trajectory"]
    return len(read_table(dataset / "provenance.parquet", names).drop_duplicates(names))


def attempt_counts(artifacts: Mapping[str, Path]) -> tuple[int, int]:
    """Attempts of all garments that `valid_trajectories` judged, and those of them that it accepted."""
    accepted = read_decisions(artifacts)["accepted"]
    return len(accepted), int(accepted.sum())
