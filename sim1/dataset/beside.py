"""What this project writes beside a LeRobot dataset: where every episode comes from, which vertices are keypoints, the robot's limits."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import pandas as pd

from sim1.dataset.limits import FILE as LIMITS
from sim1.dataset.tables import DAMAGED
from sim1.stage import BadInput

PROVENANCE, KEYPOINTS = "provenance.parquet", "keypoints.json"
FILES = (PROVENANCE, KEYPOINTS, LIMITS)
ORIGIN = ("episode_index", "garment", "trajectory", "appearance", "sources")  # columns that say which episode it is


@dataclass(frozen=True, kw_only=True)
class Beside:
    """Of one dataset; None where it has no such file."""

    folder: Path
    provenance: pd.DataFrame | None  # a row for each episode, in their order
    keypoints: Mapping[str, list[int]] | None  # garment -> vertices of its mesh
    limits: Mapping[str, list[float]] | None  # lower and upper of every number of state and action

    @classmethod
    def of(cls, folder: Path, *, episode_count: int) -> Self:
        """Read them, for a dataset of so many episodes, whose artifact or whose `lerobot/` therein is given.

        Raises:
            BadInput: one of them is damaged, or tells of other episodes.
        """
        folder = artifact_of(folder)
        path = folder / PROVENANCE
        table = read_provenance(path) if path.is_file() else None
        if table is not None and table["episode_index"].tolist() != list(range(episode_count)):
            raise BadInput(
                f"{path}: rows of episodes {table['episode_index'].tolist()!s:.60}, the dataset has 0 to {episode_count - 1}; "
                "make the dataset again, or remove the file where its episodes need not be told apart"
            )
        return cls(folder=folder, provenance=table, keypoints=_json(folder / KEYPOINTS), limits=_json(folder / LIMITS))

    def of_episodes(self, episodes: Sequence[int]) -> "Beside":
        """The same for these episodes alone, in this order."""
        if self.provenance is None:
            return self
        return replace(self, provenance=self.provenance.iloc[list(episodes)].reset_index(drop=True))

    def write(self, out: Path) -> None:
        """Write them beside the dataset in `out`, episodes numbered anew."""
        if self.provenance is not None:
            rows = self.provenance.assign(episode_index=np.arange(len(self.provenance)))
            rows.to_parquet(out / PROVENANCE, index=False)
        for name, content in ((KEYPOINTS, self.keypoints), (LIMITS, self.limits)):
            if content is not None:
                (out / name).write_text(json.dumps(content, indent=1) + "\n")


def artifact_of(folder: Path) -> Path:
    """The folder in which these files lie: the given one, or the artifact whose `lerobot/` it is.

    Only provenance tells of an artifact: any other folder may be called `lerobot`.
    """
    for place in (folder.absolute(), folder.resolve()):  # either may be a link
        if place.name == "lerobot" and not (folder / PROVENANCE).is_file() and (place.parent / PROVENANCE).is_file():
            return place.parent
    return folder


def lacking(folder: Path) -> list[str]:
    """Which of these files a dataset does not have; see `artifact_of`."""
    return [name for name in FILES if not (artifact_of(folder) / name).is_file()]


def read_provenance(path: Path) -> pd.DataFrame:
    """The table, by episode.

    Raises:
        BadInput: the file is missing or damaged, or a column that names an episode is missing.
    """
    try:
        table = pd.read_parquet(path)
    except DAMAGED as error:
        raise BadInput(f"{path}: damaged ({error}); make the dataset again") from error
    if missing := [name for name in ORIGIN if name not in table]:
        raise BadInput(f"{path}: no column {', '.join(missing)}; make the dataset again")
    return table.sort_values("episode_index", ignore_index=True)


def joined(parts: Sequence[Beside]) -> Beside:
    """Of the datasets one after the other; what one of them lacks, the whole lacks.

    A dataset numbers its trajectories from 0000: where two have the same, they are called 1-0000, 2-0000 by the place of their
    dataset, as equal names say equal motion. Source demonstrations keep their names: that they may be kin keeps a test honest.

    Raises:
        BadInput: datasets of robots with other limits, or of another mesh under a garment's name.
    """
    first, keypoints = parts[0], {}
    for part in parts:
        if None not in (part.limits, first.limits) and part.limits != first.limits:
            raise BadInput(f"{part.folder / LIMITS}: not as in {first.folder}; only data of one robot are merged")
        for garment, vertices in (part.keypoints or {}).items():
            if keypoints.setdefault(garment, vertices) != vertices:
                raise BadInput(
                    f"{part.folder / KEYPOINTS}: {garment} has other vertices than in a dataset before: of another mesh, whose "
                    "keypoints do not compare; give that garment another name"
                )
    return Beside(
        folder=first.folder,
        provenance=_one_table([part.provenance for part in parts]),
        keypoints=None if any(part.keypoints is None for part in parts) else keypoints,
        limits=None if any(part.limits is None for part in parts) else first.limits,
    )


def _one_table(tables: Sequence[pd.DataFrame | None]) -> pd.DataFrame | None:
    if any(table is None for table in tables):
        return None
    names = [set(zip(table["garment"], table["trajectory"], strict=True)) for table in tables]
    if len(set().union(*names)) < sum(map(len, names)):
        tables = [t.assign(trajectory=f"{place}-" + t["trajectory"]) for place, t in enumerate(tables, start=1)]
    return pd.concat(tables, ignore_index=True)


def _json(path: Path) -> Any:
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: damaged ({error}); make the dataset again") from error
    if not isinstance(content, dict):
        raise BadInput(f"{path}: damaged (the file is {content!r:.40}, not values by name); make the dataset again")
    return content
