"""The tables of a LeRobot v3 dataset, read with pyarrow alone and held to what info.json says of them."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import BaseModel, Field, NonNegativeInt, PositiveInt, TypeAdapter, ValidationError

from sim1.data_file import explained
from sim1.stage import BadInput

INFO, STATS, TASKS, EPISODES = "meta/info.json", "meta/stats.json", "meta/tasks.parquet", "meta/episodes"
VISUAL, TEXT = ("video", "image"), ("string", "language")  # dtypes that are no numbers in a column
NUMBERING = ("index", "frame_index", "episode_index", "task_index")
# What a reader of files raises.
DAMAGED = (OSError, ValueError, KeyError, TypeError, AttributeError, NotImplementedError, pa.ArrowException)
TIME_TOLERANCE_S = 1e-4  # of LeRobot's own reader
REMEDY = "restore the file, or write the dataset again"


class _Feature(BaseModel):
    dtype: str
    shape: tuple[PositiveInt, ...] = Field(min_length=1)


class _Info(BaseModel):
    codebase_version: str
    fps: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    features: dict[str, _Feature]
    total_episodes: NonNegativeInt
    total_frames: NonNegativeInt
    total_tasks: NonNegativeInt
    data_path: str
    video_path: str | None = None
    splits: dict[str, Annotated[str, Field(pattern=r"^\d+:\d+$")]] = Field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Tables:
    """A dataset's files, read."""

    info: dict[str, Any]
    stats: dict[str, dict[str, Any]]  # feature -> statistic -> value
    tasks: pd.DataFrame
    episodes: pd.DataFrame  # by episode_index
    episode_stats: pd.DataFrame  # columns stats/FEATURE/STATISTIC, rows as `episodes`
    frames: pd.DataFrame  # in the order of the files
    files: tuple[tuple[str, int], ...]  # data files as `frames` has them: path below the root, rows

    def file_of(self, row: int) -> tuple[str, int]:
        """The data file that holds a row of `frames`, and the row's place in it."""
        for path, count in self.files:
            if row < count:
                return path, row
            row -= count
        raise IndexError(f"row {row} after the last file")

    def place(self, row: int) -> str:
        """The same for a message."""
        path, inside = self.file_of(row)
        return f"{path} row {inside}"


def read_tables(root: Path) -> Tables:
    """Read all tables.

    Raises:
        BadInput: a file is missing, damaged or not of version 3, or a column is not as info.json has it.
    """
    info = _read_info(root)
    stats = _read_json(root, STATS)
    if bad := [name for name, one in stats.items() if not isinstance(one, dict)]:
        raise BadInput(f"{STATS}: {bad[0]} is {stats[bad[0]]!r:.80}, not statistics by name; {REMEDY}")
    features = {name: one for name, one in info["features"].items() if one["dtype"] != "video"}
    expected = {name: (one["dtype"], tuple(one["shape"])) for name, one in features.items()}
    parts = _parts(root, "data", "*/*.parquet")
    frames = pd.concat([_typed(path, table, expected) for path, table in parts], ignore_index=True)
    episodes = _read_episodes(root, info)
    statistics = [name for name in episodes.columns if name.startswith("stats/")]
    return Tables(
        info=info,
        stats=stats,
        tasks=_read_tasks(root),
        episodes=episodes.drop(columns=statistics),
        episode_stats=episodes[statistics],
        frames=frames,
        files=tuple((path, table.num_rows) for path, table in parts),
    )


def column(frames: pd.DataFrame, name: str) -> np.ndarray:
    """A column of scalars or lists as an array (n, ...)."""
    return np.array(
        [plain(cell) if isinstance(cell, np.ndarray) and cell.dtype == object else cell for cell in frames[name]]
    )


def plain(value: Any) -> Any:
    """Arrays within arrays, as parquet has them, as lists."""
    if isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim):
        return [plain(one) for one in value]
    return value


def _read_info(root: Path) -> dict[str, Any]:
    info = _read_json(root, INFO)
    version = str(info.get("codebase_version"))
    if not version.startswith("v3."):
        raise BadInput(
            f"{INFO}: codebase_version is {version!r}, expected v3; convert the dataset with LeRobot's own tool"
        )
    try:
        TypeAdapter(_Info).validate_python(info)
    except ValidationError as error:
        raise BadInput(f"{INFO}: {explained(error)}; {REMEDY}") from error
    features = info["features"]
    if missing := sorted({*NUMBERING, "timestamp"} - set(features)):
        raise BadInput(f"{INFO}: features has no {', '.join(missing)}; {REMEDY}")
    for name, feature in features.items():
        shape, names = feature["shape"], feature.get("names")
        if feature["dtype"] in VISUAL and len(shape) != 3:
            raise BadInput(f"{INFO}: features.{name}.shape is {shape}, expected height, width and channels; {REMEDY}")
        if feature["dtype"] not in VISUAL and len(shape) == 1 and isinstance(names, list) and len(names) != shape[0]:
            raise BadInput(f"{INFO}: features.{name} has {len(names)} names for {shape[0]} values; {REMEDY}")
    for key in ("data_path", "video_path"):
        try:
            str(info.get(key)).format(video_key="", chunk_index=0, file_index=0)
        except (KeyError, IndexError, ValueError) as error:
            raise BadInput(f"{INFO}: {key} is {info[key]!r}: unknown place {error} in it; {REMEDY}") from error
    if info.get("video_path") is None and any(feature["dtype"] == "video" for feature in features.values()):
        raise BadInput(f"{INFO}: video_path is missing, and features has videos; {REMEDY}")
    return info


def _read_json(root: Path, name: str) -> dict[str, Any]:
    try:
        content = json.loads((root / name).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInput(f"{name}: not readable ({_said(error)}); {REMEDY}") from error
    if not isinstance(content, dict):
        raise BadInput(f"{name}: the file is {content!r:.80}, not values by name; {REMEDY}")
    return content


def _parts(root: Path, folder: str, pattern: str) -> list[tuple[str, pa.Table]]:
    """Every parquet file of a folder, in LeRobot's order: path below the root, table."""
    paths = sorted((root / folder).glob(pattern))
    if not paths:
        raise BadInput(f"{folder}: no parquet file in it; {REMEDY}")
    return [(path.relative_to(root).as_posix(), _read_parquet(root, path)) for path in paths]


def _read_parquet(root: Path, path: Path) -> pa.Table:
    try:
        with pq.ParquetFile(path) as file:  # not read_table: folder names are no columns
            table = file.read()
            table.validate(full=True)  # texts may hold bytes that are no UTF-8
            return table
    except DAMAGED as error:
        raise BadInput(f"{path.relative_to(root)}: not readable as parquet ({_said(error)}); {REMEDY}") from error


def _read_episodes(root: Path, info: dict[str, Any]) -> pd.DataFrame:
    whole = ["episode_index", "length", "dataset_from_index", "dataset_to_index", "data/chunk_index", "data/file_index"]
    whole += [f"{EPISODES}/chunk_index", f"{EPISODES}/file_index"]
    times = []
    for name, feature in info["features"].items():
        if feature["dtype"] == "video":
            whole += [f"videos/{name}/chunk_index", f"videos/{name}/file_index"]
            times += [f"videos/{name}/from_timestamp", f"videos/{name}/to_timestamp"]
    expected = dict.fromkeys(whole, ("int64", (1,))) | dict.fromkeys(times, ("float64", (1,)))
    tables = []
    for path, part in _parts(root, EPISODES, "*/*.parquet"):
        table = _typed(path, part, expected)
        if "tasks" not in table:
            raise BadInput(f"{path}: no column tasks; {REMEDY}")
        for row, (chunk, file) in enumerate(zip(table[f"{EPISODES}/chunk_index"], table[f"{EPISODES}/file_index"])):
            if (said := f"{EPISODES}/chunk-{chunk:03d}/file-{file:03d}.parquet") != path:
                raise BadInput(f"{path} row {row}: said to be in {said}; {REMEDY}")
        for name, low in (("length", 1), ("dataset_from_index", 0)):
            if (table[name] < low).any():
                row = int((table[name] < low).to_numpy().argmax())
                raise BadInput(f"{path} row {row}: {name} is {table[name].iloc[row]}, expected {low} or more; {REMEDY}")
        for name in times:
            if not np.isfinite(table[name]).all():
                row = int((~np.isfinite(table[name])).to_numpy().argmax())
                raise BadInput(f"{path} row {row}: {name} is {table[name].iloc[row]}, expected seconds; {REMEDY}")
        tables.append(table)
    return pd.concat(tables, ignore_index=True).sort_values("episode_index", ignore_index=True, kind="stable")


def _read_tasks(root: Path) -> pd.DataFrame:
    """Task texts as the index, as LeRobot has them."""
    table = _typed(TASKS, _read_parquet(root, root / TASKS), {"task_index": ("int64", (1,))})
    if wrong := [text for text in table.index if not isinstance(text, str)]:
        raise BadInput(f"{TASKS}: the index is {wrong[0]!r}, expected a task in words; {REMEDY}")
    return table


def _typed(path: str, table: pa.Table, expected: dict[str, tuple[str, tuple[int, ...]]]) -> pd.DataFrame:
    """The table with every expected column there, of its type and shape, without empty cells."""
    if missing := sorted(set(expected) - set(table.column_names)):
        raise BadInput(f"{path}: no column {', '.join(missing)}; {REMEDY}")
    try:
        frame = table.to_pandas()  # by what pandas has noted in the file, which may be damaged too
    except DAMAGED as error:
        raise BadInput(f"{path}: not readable as a table ({_said(error)}); {REMEDY}") from error
    for name, (dtype, shape) in expected.items():
        cells = table[name]
        if cells.null_count:
            row = cells.is_null().to_pylist().index(True)
            raise BadInput(f"{path} row {row}: {name} is empty; {REMEDY}")
        if dtype in (*VISUAL, *TEXT):
            continue
        kind = _value_type(cells.type)
        if not _is(kind, dtype):
            raise BadInput(f"{path}: {name} holds {kind} values, expected {dtype}; {REMEDY}")
        wanted = () if shape == (1,) else shape
        wrong = next((row for row, cell in enumerate(frame[name]) if _shape(cell) != wanted), None)
        if wrong is not None:
            found = _shape(frame[name].iloc[wrong])
            raise BadInput(f"{path} row {wrong}: {name} has shape {found}, expected {wanted}; {REMEDY}")
    return frame


def _value_type(kind: pa.DataType) -> pa.DataType:
    """Of the numbers inside lists of lists."""
    while True:
        if isinstance(kind, pa.BaseExtensionType):
            kind = kind.storage_type
        elif pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind):
            kind = kind.value_type
        else:
            return kind


def _is(kind: pa.DataType, dtype: str) -> bool:
    try:
        return kind == pa.from_numpy_dtype(np.dtype(dtype))
    except (TypeError, NotImplementedError, pa.ArrowException) as error:
        raise BadInput(f"{INFO}: {dtype!r} is no dtype of a feature ({error}); {REMEDY}") from error


def _shape(cell: Any) -> tuple[int, ...] | None:
    """None for lists of unequal length."""
    try:
        return np.shape(plain(cell) if isinstance(cell, np.ndarray) and cell.dtype == object else cell)
    except ValueError:
        return None


def _said(error: BaseException) -> str:
    """An error in one line."""
    return " ".join(str(error).split()) or type(error).__name__
