"""Checks for any LeRobot v3 dataset, read with pyarrow and PyAV alone: what its own loader takes for granted."""

from pathlib import Path

import numpy as np

from sim1.dataset.tables import (
    EPISODES,
    INFO,
    TASKS,
    TEXT,
    TIME_TOLERANCE_S,
    VISUAL,
    Tables,
    column,
    plain,
    read_tables,
)
from sim1.stage import BadInput, Finding

SHOWN = 3  # faults in a finding's line
JOINT_SLACK = 1e-3  # rad or openness: rounding, not motion


def check_lerobot(root: Path, *, limits: tuple[np.ndarray, np.ndarray] | None = None) -> list[Finding]:
    """Check the dataset in `root`.

    Args:
        root: folder with `meta/`, `data/` and, where there are cameras, `videos/`.
        limits: lower and upper bound of `observation.state` and `action`, (n,) each, in the dataset's units.

    Returns:
        Findings `tables_readable`, `counts_agree`, `indices_run_on`, `timestamps_on_grid`, `values_finite`,
        `tasks_known`, `statistics_true`, `videos_complete`, `images_readable`, and `joints_within_limits` where limits are
        given. Only the first where that fails.
    """
    from sim1.dataset.check_images import check_images
    from sim1.dataset.check_statistics import check_statistics
    from sim1.dataset.check_videos import check_videos

    try:
        tables = read_tables(root)
    except BadInput as error:
        return [Finding(name="tables_readable", passed=False, detail=f"{root.name}: {error}")]
    findings = [
        Finding(
            name="tables_readable", passed=True, detail=f"{len(tables.episodes)} episodes, {len(tables.frames)} frames"
        ),
        _counts(tables),
        _indices(tables),
        _timestamps(tables),
        _finite(tables),
        _tasks(tables),
        check_statistics(tables),
        check_videos(root, tables),
        check_images(root, tables),
    ]
    if limits is not None:
        findings.append(_limits(tables, *limits))
    return findings


def _counts(tables: Tables) -> Finding:
    info, faults = tables.info, []
    for name, found, where in (
        ("total_episodes", len(tables.episodes), EPISODES),
        ("total_frames", len(tables.frames), "data"),
        ("total_tasks", len(tables.tasks), TASKS),
    ):
        if info[name] != found:
            faults.append(f"{INFO}: {name} is {info[name]}, {where} has {found}")
    if (said := tables.episodes["length"].sum()) != len(tables.frames):
        faults.append(f"{EPISODES}: the lengths add up to {said}, data has {len(tables.frames)} frames")
    if not len(tables.episodes):
        faults.append(f"{EPISODES}: no episode")
    for name, text in info.get("splits", {}).items():
        begin, end = map(int, text.split(":"))
        if not begin <= end <= len(tables.episodes):
            faults.append(f"{INFO}: split {name} is {text}, of {len(tables.episodes)} episodes")
    return finding("counts_agree", faults, f"{len(tables.episodes)} episodes, {len(tables.frames)} frames")


def _indices(tables: Tables) -> Finding:
    """Frames are numbered through, and within each episode; the episode table tells where each one lies."""
    frames, episodes, faults = tables.frames, tables.episodes, []
    if (wrong := np.flatnonzero(frames["index"] != np.arange(len(frames)))).size:
        row = int(wrong[0])
        faults.append(f"{tables.place(row)}: index is {frames['index'][row]}, expected {row}")
    if (wrong := np.flatnonzero(episodes["episode_index"] != np.arange(len(episodes)))).size:
        found = episodes["episode_index"][wrong[0]]
        faults.append(f"{EPISODES}: episode_index {found} where {wrong[0]} is expected")
    start = 0
    for row in episodes.to_dict("records"):
        name, end = f"{EPISODES}: episode {row['episode_index']}", start + row["length"]
        part = frames.iloc[start:end]
        for key, expected in (("episode_index", row["episode_index"]), ("frame_index", np.arange(len(part)))):
            if (wrong := np.flatnonzero(part[key] != expected)).size:
                at = start + int(wrong[0])
                said = np.broadcast_to(expected, len(part))[wrong[0]]
                faults.append(f"{tables.place(at)}: {key} is {frames[key][at]}, expected {said}")
        if (found := (row["dataset_from_index"], row["dataset_to_index"])) != (start, end):
            faults.append(f"{name}: said to be at frames {found[0]}..{found[1]}, expected {start}..{end}")
        said = tables.info["data_path"].format(chunk_index=row["data/chunk_index"], file_index=row["data/file_index"])
        if holders := {tables.file_of(at)[0] for at in (start, end - 1) if at < len(frames)} - {said}:
            faults.append(f"{name}: said to be in {said}, its frames are in {', '.join(sorted(holders))}")
        start = end
    return finding("indices_run_on", faults, f"{len(frames)} frames in {len(episodes)} episodes")


def _timestamps(tables: Tables) -> Finding:
    frames = tables.frames
    off = np.abs(frames["timestamp"].to_numpy() - frames["frame_index"].to_numpy() / tables.info["fps"])
    wrong = np.flatnonzero(~(off <= TIME_TOLERANCE_S))  # NaN as well
    said = [
        f"{tables.place(row)}: timestamp is {frames['timestamp'][row]:g} s, {off[row]:.2g} s off frame_index / fps"
        for row in map(int, wrong[:SHOWN])
    ]
    worst = off.max() if len(off) else 0.0
    fine = f"worst {worst:.2g} s off, limit {TIME_TOLERANCE_S:g} s"
    return finding("timestamps_on_grid", said, fine, count=len(wrong))


def _finite(tables: Tables) -> Finding:
    faults = []
    for name, feature in tables.info["features"].items():
        if feature["dtype"] in (*VISUAL, *TEXT):
            continue
        values = column(tables.frames, name)
        if values.dtype.kind == "f" and (wrong := np.argwhere(~np.isfinite(values))).size:
            row, *place = wrong[0].tolist()
            faults.append(f"{tables.place(row)}: {name}{place or ''} is {values[*wrong[0]]} ({len(wrong)} such values)")
    return finding("values_finite", faults, "all numeric columns")


def _tasks(tables: Tables) -> Finding:
    """LeRobot takes the text of a frame's task from the row of that number, and finds a task by its text."""
    tasks, frames, episodes = tables.tasks, tables.frames, tables.episodes
    faults = []
    if (wrong := np.flatnonzero(tasks["task_index"] != np.arange(len(tasks)))).size:
        row = int(wrong[0])
        faults.append(f"{TASKS} row {row}: task_index is {tasks['task_index'].iloc[row]}, expected {row}")
    if tasks.index.has_duplicates:
        faults.append(f"{TASKS}: {tasks.index[tasks.index.duplicated()][0]!r} is there twice")
    known = frames["task_index"].between(0, len(tasks) - 1)
    for row in map(int, np.flatnonzero(~known)[:SHOWN]):
        faults.append(f"{tables.place(row)}: task_index is {frames['task_index'][row]}, {TASKS} has {len(tasks)} rows")
    if faults:
        return finding("tasks_known", faults, "")
    used = frames.groupby("episode_index")["task_index"].unique()
    for index, said in zip(episodes["episode_index"], episodes["tasks"], strict=True):
        found = {tasks.index[task] for task in used.get(index, [])}
        if set(plain(said)) != found:
            faults.append(f"{EPISODES}: tasks of episode {index} are {plain(said)}, its frames have {sorted(found)}")
    return finding("tasks_known", faults, f"{len(tasks)} tasks")


def _limits(tables: Tables, lower: np.ndarray, upper: np.ndarray) -> Finding:
    faults = []
    for name in ("observation.state", "action"):
        if name not in tables.info["features"]:
            faults.append(f"{INFO}: features has no {name}, limits are given for it")
            continue
        values = column(tables.frames, name)
        if values.shape[1:] != lower.shape:
            faults.append(f"{INFO}: {name} has shape {values.shape[1:]}, limits are given for {lower.shape}")
            continue
        outside = (values < lower - JOINT_SLACK) | (values > upper + JOINT_SLACK)
        if outside.any():
            frame, joint = map(int, np.argwhere(outside)[0])
            faults.append(
                f"{tables.place(frame)}: {name}[{joint}] is {values[frame, joint]:.4g}, "
                f"limits {lower[joint]:.4g} to {upper[joint]:.4g}"
            )
    return finding("joints_within_limits", faults, "state and action")


def finding(name: str, faults: list[str], fine: str, *, count: int | None = None) -> Finding:
    """A finding that fails when there are faults, and shows the first of them. `count`: of all, where only some are given."""
    said = f"{len(faults) if count is None else count} at fault: {'; '.join(faults[:SHOWN])}"
    return Finding(name=name, passed=not faults, detail=said if faults else fine)
