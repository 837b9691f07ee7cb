"""One column of one episode of a LeRobot dataset (version 3), and where each of its frames stands."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Episode:
    """A column with k values in each of n frames."""

    index: int
    column: str
    names: list[str]  # k
    time_s: np.ndarray  # (n,) finite
    values: np.ndarray  # (n, k), as the dataset has them
    files: list[Path]  # n
    rows: np.ndarray  # (n,) of the file, from 0

    def place(self, frame: int) -> str:
        """Where a frame stands, for messages; frames of an episode count from 0."""
        return _place(self.files[frame], self.rows[frame], self.index, frame)


def read_episode(dataset: Path, index: int, column: str) -> Episode:
    """Read one column, as "action", of the episode `index`.

    Raises:
        BadInput: not such a dataset, no such episode or column, a frame without a time or with another number of values.
    """
    info = dataset / "meta" / "info.json"
    names, count = _names(info, column)
    parts = [part for file in _files(dataset) if len(part := _frames(file, index, column))]
    if not parts:
        raise BadInput(
            f"{dataset}: there is no episode {index}; info.json counts {count}, from 0: correct episode in import.yaml"
        )
    found = pd.concat(parts, ignore_index=True)
    files, rows = list(found["file"]), found["row"].to_numpy()
    for frame, value in enumerate(found[column]):
        if len(value) != len(names):
            raise BadInput(
                f"{_place(files[frame], rows[frame], index, frame)}: {column} has {len(value)} values for {len(names)} names in "
                f"{info}; repair the dataset"
            )
    time, values = found["timestamp"].to_numpy(float), np.array(list(found[column]), float)
    episode = Episode(index=index, column=column, names=names, time_s=time, values=values, files=files, rows=rows)
    if (untimed := ~np.isfinite(time)).any():
        frame = int(np.argmax(untimed))
        raise BadInput(
            f"{episode.place(frame)}: timestamp is {time[frame]}; every frame has its time: repair the dataset"
        )
    return episode


def _place(file: Path, row: int, episode: int, frame: int) -> str:
    return f"{file}: row {row} (episode {episode}, frame {frame})"


def _names(path: Path, column: str) -> tuple[list[str], object]:
    """Names of a column's values, and how many episodes there are, by info.json."""
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
        version, names = str(info["codebase_version"]), info["features"][column]["names"]
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: not readable ({error}); expected a LeRobot dataset, version 3") from error
    except (KeyError, TypeError) as error:
        raise BadInput(
            f"{path}: no codebase_version or no features.{column}.names; expected a LeRobot dataset, version 3"
        ) from error
    if not version.startswith("v3"):
        raise BadInput(f"{path}: codebase_version is {version!r}; convert the dataset to version 3 with lerobot")
    names = next(iter(names.values())) if isinstance(names, dict) and names else names
    if not isinstance(names, list):
        raise BadInput(f"{path}: features.{column}.names is {names!r:.80}; expected a list of names")
    return [str(name) for name in names], info.get("total_episodes")


def _files(dataset: Path) -> list[Path]:
    files = sorted((dataset / "data").rglob("*.parquet"))
    if not files:
        raise BadInput(f"{dataset}/data: no Parquet file; copy the whole dataset")
    return files


def _frames(file: Path, index: int, column: str) -> pd.DataFrame:
    """Frames of one episode in one file, with the file and the row of each."""
    try:
        table = pd.read_parquet(file, columns=["episode_index", "timestamp", column]).reset_index(drop=True)
    except Exception as error:  # damaged Parquet raises many kinds
        raise BadInput(_not_readable(file, error)) from error
    part = table[table["episode_index"] == index]
    try:
        values = part[column].map(_floats)
        return part.astype({"timestamp": float}).assign(file=file, row=part.index, **{column: values})
    except (TypeError, ValueError) as error:  # columns of another type
        raise BadInput(_not_readable(file, error)) from error


def _not_readable(file: Path, error: Exception) -> str:
    return f"{file}: not readable ({' '.join(str(error).split())[:120]}); copy the dataset again"


def _floats(value: object) -> np.ndarray:
    return np.ravel(np.asarray(value, float))
