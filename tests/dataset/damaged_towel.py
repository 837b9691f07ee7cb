"""Damage done to a written dataset, for the tests of what finds it."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

FRAMES, EPISODES, VIDEO = "data/**/*.parquet", "meta/episodes/**/*.parquet", "videos/**/*.mp4"


def only_file(artifact: Path, pattern: str) -> Path:
    (path,) = artifact.glob(f"lerobot/{pattern}")
    return path


def change_table(path: Path, change) -> None:
    table = pd.read_parquet(path)
    changed = change(table)
    (table if changed is None else changed).to_parquet(path, index=path.name == "tasks.parquet")


def set_cell(table: pd.DataFrame, row: int, name: str, value, index: int | None = None) -> None:
    if index is not None:
        array = np.array(table.at[row, name])
        array[index] = value
        value = array
    table.at[row, name] = value


def change_json(path: Path, **values) -> None:
    path.write_text(json.dumps({**json.loads(path.read_text()), **values}))


def cut(path: Path) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
