"""Checks for any LeRobot v3 dataset, read with pyarrow and PyAV alone: what its own loader takes for granted."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sim1.stage import Finding

TIME_TOLERANCE_S = 1e-4  # LeRobot's own
JOINT_SLACK = 1e-3  # rad or openness: rounding, not motion


@dataclass(frozen=True, kw_only=True)
class Tables:
    """A dataset's files, read."""

    info: dict[str, Any]
    stats: dict[str, Any]
    tasks: pd.DataFrame
    episodes: pd.DataFrame  # by episode_index
    frames: pd.DataFrame  # in the order of the files


def check_lerobot(root: Path, *, limits: tuple[np.ndarray, np.ndarray] | None = None) -> list[Finding]:
    """Check the dataset in `root`.

    Args:
        root: folder with `meta/`, `data/` and, where there are cameras, `videos/`.
        limits: lower and upper bound of `observation.state` and `action`, (n,) each, in the dataset's units.

    Returns:
        Findings `tables_readable`, `counts_agree`, `indices_run_on`, `timestamps_on_grid`, `values_finite`,
        `tasks_known`, `statistics_true`, `videos_complete`, and `joints_within_limits` where limits are given. Only the
        first where that fails.
    """
    from sim1.dataset.check_videos import check_videos

    try:
        tables = read_tables(root)
    except (OSError, KeyError, ValueError) as error:  # pyarrow's errors are among these
        return [Finding(name="tables_readable", passed=False, detail=f"{root.name}: {type(error).__name__}: {error}")]
    findings = [
        Finding(
            name="tables_readable", passed=True, detail=f"{len(tables.episodes)} episodes, {len(tables.frames)} frames"
        ),
        _counts(tables),
        _indices(tables),
        _timestamps(tables),
        _finite(tables),
        _tasks(tables),
        _statistics(tables),
        check_videos(root, tables),
    ]
    if limits is not None:
        findings.append(_limits(tables, *limits))
    return findings


def read_tables(root: Path) -> Tables:
    """Read all tables.

    Raises:
        OSError, KeyError, ValueError: a file is missing, damaged, or not of version 3.
    """
    info = json.loads((root / "meta" / "info.json").read_text())
    if not str(info["codebase_version"]).startswith("v3."):
        raise ValueError(f"meta/info.json: codebase_version is {info['codebase_version']!r}, expected v3")
    stats = json.loads((root / "meta" / "stats.json").read_text())
    episodes = _read_all(root / "meta" / "episodes").sort_values("episode_index", ignore_index=True)
    frames = _read_all(root / "data")
    _need(frames, {*_stored(info), "index", "frame_index", "episode_index", "timestamp", "task_index"}, "data")
    places = {
        f"videos/{name}/{part}"
        for name, feature in info["features"].items()
        if feature["dtype"] == "video"
        for part in ("chunk_index", "file_index", "from_timestamp", "to_timestamp")
    }
    _need(episodes, {"episode_index", "length", "dataset_from_index", "dataset_to_index", *places}, "meta/episodes")
    return Tables(
        info=info,
        stats=stats,
        tasks=pd.read_parquet(root / "meta" / "tasks.parquet"),
        episodes=episodes[[name for name in episodes.columns if not name.startswith("stats/")]],
        frames=frames,
    )


def column(frames: pd.DataFrame, name: str) -> np.ndarray:
    """A column of scalars or lists as an array (n, ...)."""
    return np.array(frames[name].tolist())


def _stored(info: dict[str, Any]) -> list[str]:
    """Features that have a column in the tables; videos do not."""
    return [name for name, feature in info["features"].items() if feature["dtype"] != "video"]


def _need(table: pd.DataFrame, columns: set[str], where: str) -> None:
    if missing := sorted(columns - set(table.columns)):
        raise KeyError(f"{where} has no column {', '.join(missing)}")


def _read_all(folder: Path) -> pd.DataFrame:
    files = sorted(folder.rglob("*.parquet"))
    if not files:
        raise FileNotFoundError(f"no parquet file under {folder.name}")
    return pd.concat([pd.read_parquet(file) for file in files], ignore_index=True)


def _counts(tables: Tables) -> Finding:
    said = (tables.info["total_episodes"], tables.info["total_frames"], tables.info["total_tasks"])
    found = (len(tables.episodes), len(tables.frames), len(tables.tasks))
    same = said == found and found[1] == tables.episodes["length"].sum() and found[0] > 0
    return Finding(
        name="counts_agree", passed=bool(same), detail=f"episodes, frames, tasks: info.json {said}, tables {found}"
    )


def _indices(tables: Tables) -> Finding:
    """Frames are numbered through, and within each episode; the episode table tells where each one lies."""
    frames, episodes, faults = tables.frames, tables.episodes, []
    if not np.array_equal(frames["index"], np.arange(len(frames))):
        faults.append("index does not run from 0 without gaps")
    if not np.array_equal(episodes["episode_index"], np.arange(len(episodes))):
        faults.append("episode_index does not run from 0 without gaps")
    start = 0
    for row in episodes.itertuples(index=False):
        part = frames.iloc[start : start + row.length]
        if (
            not np.array_equal(part["frame_index"], np.arange(row.length))
            or (part["episode_index"] != row.episode_index).any()
        ):
            faults.append(f"episode {row.episode_index}: frames are not 0..{row.length - 1}")
        if (row.dataset_from_index, row.dataset_to_index) != (start, start + row.length):
            faults.append(
                f"episode {row.episode_index}: said to be at {row.dataset_from_index}..{row.dataset_to_index}"
            )
        start += row.length
    return finding("indices_run_on", faults, f"{len(frames)} frames in {len(episodes)} episodes")


def _timestamps(tables: Tables) -> Finding:
    off = np.abs(tables.frames["timestamp"] - tables.frames["frame_index"] / tables.info["fps"])
    worst = float(off.max()) if len(off) else 0.0
    passed = worst <= TIME_TOLERANCE_S  # False for NaN as well
    return Finding(
        name="timestamps_on_grid", passed=passed, detail=f"worst {worst:.2g} s off, limit {TIME_TOLERANCE_S:g} s"
    )


def _finite(tables: Tables) -> Finding:
    faults = []
    for name, feature in tables.info["features"].items():
        if feature["dtype"] in ("video", "image", "string"):
            continue
        values = column(tables.frames, name)
        width = int(np.prod(feature["shape"]))
        if values.size != len(tables.frames) * width:
            faults.append(f"{name}: {values.size // max(len(values), 1)} values a frame, {width} expected")
        elif values.dtype.kind == "f" and not np.isfinite(values).all():
            faults.append(f"{name}: {int((~np.isfinite(values)).sum())} values not finite")
    return finding("values_finite", faults, "all numeric columns")


def _tasks(tables: Tables) -> Finding:
    unknown = sorted(set(tables.frames["task_index"]) - set(tables.tasks["task_index"]))
    return finding("tasks_known", [f"task_index {index}" for index in unknown], f"{len(tables.tasks)} tasks")


def _statistics(tables: Tables) -> Finding:
    """What policies are normalised with is true of the data."""
    faults = []
    for name in ("observation.state", "action"):
        if name not in tables.info["features"]:
            continue
        values = column(tables.frames, name)
        for key, true in (("min", values.min(axis=0)), ("max", values.max(axis=0)), ("mean", values.mean(axis=0))):
            said = np.asarray(tables.stats.get(name, {}).get(key, np.nan), float)
            if not np.allclose(said, true, atol=1e-4, rtol=1e-3):
                faults.append(f"{key} of {name}")
    return finding("statistics_true", faults, "min, max and mean of state and action")


def _limits(tables: Tables, lower: np.ndarray, upper: np.ndarray) -> Finding:
    faults = []
    for name in ("observation.state", "action"):
        values = column(tables.frames, name)
        outside = (values < lower - JOINT_SLACK) | (values > upper + JOINT_SLACK)
        if outside.any():
            frame, joint = np.argwhere(outside)[0]
            faults.append(
                f"{name}[{joint}] is {values[frame, joint]:.4g} at frame {frame}, limits {lower[joint]:.4g} to {upper[joint]:.4g}"
            )
    return finding("joints_within_limits", faults, "state and action")


def finding(name: str, faults: list[str], fine: str) -> Finding:
    """A finding that fails when there are faults, and shows the first of them."""
    return Finding(
        name=name, passed=not faults, detail=f"{len(faults)} at fault: {'; '.join(faults[:3])}" if faults else fine
    )
