"""Whatever is done to a dataset is named with file and place: never passed, and never an error of the program."""

import json
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from damaged_towel import EPISODES, FRAMES, VIDEO, change_json, change_table, only_file, set_cell
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.dataset.check import check_lerobot

DATA, TASKS, INFO = "data/chunk-000/file-000.parquet", "meta/tasks.parquet", "meta/info.json"
HEAD = "observation.images.head"


@contextmanager
def copy_of(good: Path) -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        yield shutil.copytree(good, Path(folder) / "artifact")


def faults(artifact: Path) -> dict[str, str]:
    return {finding.name: finding.detail for finding in check_lerobot(artifact / "lerobot") if not finding.passed}


def change_features(artifact: Path, **changes) -> None:
    path = artifact / "lerobot" / INFO
    features = json.loads(path.read_text())["features"]
    for name, change in changes.items():
        features[name.replace("__", ".")].update(change)
    change_json(path, features=features)


def drop_from_info(artifact: Path, key: str) -> None:
    path = artifact / "lerobot" / INFO
    path.write_text(json.dumps({name: value for name, value in json.loads(path.read_text()).items() if name != key}))


def in_frames(change):
    return lambda artifact: change_table(only_file(artifact, FRAMES), change)


def in_episodes(change):
    return lambda artifact: change_table(only_file(artifact, EPISODES), change)


def in_tasks(change):
    return lambda artifact: change_table(only_file(artifact, TASKS), change)


def write(name: str, content: bytes):
    return lambda artifact: (artifact / "lerobot" / name).write_bytes(content)


def overwrite(name: str, old: bytes, new: bytes):
    """Bytes of a file that are others, wherever they stand in it."""

    def damage(artifact: Path) -> None:
        content = (artifact / "lerobot" / name).read_bytes()
        assert old in content
        (artifact / "lerobot" / name).write_bytes(content.replace(old, new))

    return damage


def with_cell(row: int, name: str, value):
    """A cell of any type in a column of objects."""

    def change(table: pd.DataFrame) -> pd.DataFrame:
        cells = table[name].astype(object).tolist()
        cells[row] = value
        return table.assign(**{name: pd.Series(cells, dtype=object)})

    return change


DAMAGE = {
    "a state of another dtype": (
        in_frames(lambda t: t.assign(action=[cell.astype(np.float64) for cell in t["action"]])),
        f"{DATA}: action holds double values, expected float32",
    ),
    "states as text": (
        in_frames(lambda t: t.assign(timestamp=t["timestamp"].astype(str))),
        f"{DATA}: timestamp holds",
    ),
    "an action that is too short": (
        in_frames(with_cell(2, "action", np.zeros(9, np.float32))),
        f"{DATA} row 2: action has shape (9,), expected (14,)",
    ),
    "a state that is empty": (
        in_frames(with_cell(4, "observation.state", None)),
        f"{DATA} row 4: observation.state is",
    ),
    "a state that is not a number": (
        in_frames(lambda t: set_cell(t, 3, "observation.state", np.nan, 2)),
        f"{DATA} row 3: observation.state[2] is nan",
    ),
    "a time stamp that is not a number": (
        in_frames(lambda t: set_cell(t, 3, "timestamp", np.nan)),
        f"{DATA} row 3: timestamp is",
    ),
    "a row left out": (in_frames(lambda t: t.drop(index=5)), f"{DATA} row 5: index is 6, expected 5"),
    "a row twice": (in_frames(lambda t: t.iloc[[0, 0, *range(1, len(t))]]), f"{DATA} row 1: index is 0, expected 1"),
    "rows that are not in order": (in_frames(lambda t: t.iloc[::-1]), f"{DATA} row 0: index is 15, expected 0"),
    "an episode number left out": (
        in_frames(lambda t: t.assign(episode_index=2 * t["episode_index"])),
        f"{DATA} row 7: episode_index is 2, expected 1",
    ),
    "an episode left out of the episodes": (
        in_episodes(lambda t: t.iloc[1:]),
        "meta/info.json: total_episodes is 2, meta/episodes has 1",
    ),
    "no episode": (in_episodes(lambda t: t.iloc[:0]), "meta/episodes"),
    "an episode of no frame": (
        in_episodes(lambda t: set_cell(t, 1, "length", 0)),
        "meta/episodes/chunk-000/file-000.parquet row 1: length is 0",
    ),
    "an episode without a place in the video": (
        in_episodes(lambda t: set_cell(t, 0, f"videos/{HEAD}/to_timestamp", np.nan)),
        f"meta/episodes/chunk-000/file-000.parquet row 0: videos/{HEAD}/to_timestamp is",
    ),
    "an episode of another task": (
        in_episodes(with_cell(1, "tasks", np.array(["sing"]))),
        "meta/episodes: tasks of episode 1 are ['sing'], its frames have ['turn the towel over']",
    ),
    "a task index out of range": (
        in_frames(lambda t: set_cell(t, 6, "task_index", -1)),
        f"{DATA} row 6: task_index is -1, {TASKS} has 1 rows",
    ),
    "tasks that are not numbered from 0": (
        in_tasks(lambda t: t.assign(task_index=t["task_index"] + 1)),
        f"{TASKS} row 0: task_index is 1, expected 0",
    ),
    "tasks without words": (in_tasks(lambda t: t.reset_index(drop=True)), f"{TASKS}: the index is 0"),
    "a task that is no text": (overwrite(TASKS, b"urn the towel", b"\xfbrn the towel"), f"{TASKS}: not readable"),
    "notes of pandas that are cut up": (
        overwrite(TASKS, b'{"index_columns"', b'["index_columns"'),
        f"{TASKS}: not readable",
    ),
    "no tasks": (lambda a: only_file(a, TASKS).unlink(), f"{TASKS}: not readable"),
    "another rate": (
        lambda a: change_json(a / "lerobot" / INFO, fps=12),
        f"{DATA} row 1: timestamp is 0.1 s, 0.017 s off frame_index / fps",
    ),
    "a rate that is none": (lambda a: change_json(a / "lerobot" / INFO, fps=0), f"{INFO}: fps is 0"),
    "a rate in words": (lambda a: change_json(a / "lerobot" / INFO, fps="fast"), f"{INFO}: fps is 'fast'"),
    "no features": (lambda a: change_json(a / "lerobot" / INFO, features=[]), f"{INFO}: features is []"),
    "no shape": (lambda a: change_features(a, action={"shape": []}), f"{INFO}: features.action.shape is []"),
    "a shape of another width": (
        lambda a: change_features(a, action={"shape": [13], "names": None}),
        f"{DATA} row 0: action has shape (14,), expected (13,)",
    ),
    "too few names": (
        lambda a: change_features(a, action={"names": ["x"]}),
        f"{INFO}: features.action has 1 names for",
    ),
    "a dtype that is none": (lambda a: change_features(a, action={"dtype": "real"}), f"{INFO}: 'real' is no dtype"),
    "pictures of another size": (
        lambda a: change_features(a, observation__images__head={"shape": [64, 64, 3]}),
        "file-000.mp4: size [(48, 64)], meta/info.json says (64, 64)",
    ),
    "pictures without height and width": (
        lambda a: change_features(a, observation__images__head={"shape": [9]}),
        f"{INFO}: features.{HEAD}.shape is [9]",
    ),
    "a split of episodes that are not there": (
        lambda a: change_json(a / "lerobot" / INFO, splits={"train": "0:9"}),
        f"{INFO}: split train is 0:9, of 2 episodes",
    ),
    "a path with an unknown place": (
        lambda a: change_json(a / "lerobot" / INFO, video_path="videos/{camera}.mp4"),
        f"{INFO}: video_path is 'videos/{{camera}}.mp4': unknown place 'camera'",
    ),
    "videos that are elsewhere": (
        lambda a: change_json(a / "lerobot" / INFO, video_path="films/{video_key}.mp4"),
        f"films/{HEAD}.mp4: missing",
    ),
    "data that is said to be elsewhere": (
        lambda a: change_json(a / "lerobot" / INFO, data_path="table.parquet"),
        f"meta/episodes: episode 0: said to be in table.parquet, its frames are in {DATA}",
    ),
    "an info file that is a list": (write(INFO, b"[]"), f"{INFO}: the file is []"),
    "an info file that is no text": (write(INFO, b"\xff\xfe"), f"{INFO}: not readable"),
    "statistics that are numbers": (write("meta/stats.json", b'{"action": 3}'), "meta/stats.json: action is 3"),
    "no statistics": (lambda a: (a / "lerobot/meta/stats.json").unlink(), "meta/stats.json: not readable"),
    "a table that is text": (write(DATA, b"index,action\n0,1\n"), f"{DATA}: not readable as parquet"),
    "no tables": (lambda a: shutil.rmtree(a / "lerobot/data"), "data: no parquet file in it"),
    "a video that is missing": (lambda a: only_file(a, VIDEO).unlink(), "file-000.mp4: missing"),
    "a video that is empty": (lambda a: only_file(a, VIDEO).write_bytes(b""), "file-000.mp4: cannot be decoded"),
    **{
        f"no {key}": (lambda a, key=key: drop_from_info(a, key), f"{INFO}: ")
        for key in ("codebase_version", "fps", "features", "total_episodes", "total_frames", "total_tasks", "data_path")
    },
}


@pytest.mark.parametrize("what", DAMAGE)
def test_it_is_named_with_file_and_place(good, what):
    damage, said = DAMAGE[what]
    with copy_of(good) as artifact:
        damage(artifact)
        assert said in "\n".join(faults(artifact).values())
        answer = CliRunner().invoke(app, ["dataset", "check", str(artifact)])
        assert answer.exit_code == 1
        assert "FAILED" in answer.stdout
        parts = ["--share", "one=0.5", "--share", "other=0.5", "--out", str(artifact / "parts")]
        refused = CliRunner().invoke(app, ["dataset", "split", str(artifact), *parts])
        assert refused.exit_code == 2
        assert "`sim1 dataset check` lists all faults" in refused.stderr


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_any_number_of_the_data_that_is_another_is_found(good, data):
    table = pd.read_parquet(only_file(good, FRAMES))
    row = data.draw(st.integers(0, len(table) - 1))
    name = data.draw(st.sampled_from(sorted(table.columns)))
    old = np.atleast_1d(table.at[row, name])
    place = data.draw(st.integers(0, len(old) - 1))
    by = data.draw(st.integers(-3, 3) if old.dtype.kind == "i" else st.floats(-2.0, 2.0, width=16))
    if abs(by) < 1e-3:
        by = 1
    with copy_of(good) as artifact:
        value = old[place] + by
        in_frames(lambda t: set_cell(t, row, name, value, place if isinstance(t.at[row, name], np.ndarray) else None))(
            artifact
        )
        found = faults(artifact)
    assert name in "\n".join(found.values())


@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_any_place_or_length_of_an_episode_that_is_another_is_found(good, data):
    table = pd.read_parquet(only_file(good, EPISODES))
    names = [name for name in table.columns if not name.startswith("stats/") and name != "tasks"]
    row, name = data.draw(st.integers(0, len(table) - 1)), data.draw(st.sampled_from(names))
    by = data.draw(st.sampled_from([-2, -1, 1, 2, 500]))
    if name.endswith("_timestamp"):
        by *= 0.01
    with copy_of(good) as artifact:
        in_episodes(lambda t: set_cell(t, row, name, t.at[row, name] + by))(artifact)
        assert faults(artifact)


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_files_that_are_cut_off_are_found_and_bytes_that_are_others_are_no_error(good, data):
    names = sorted(path.relative_to(good).as_posix() for path in (good / "lerobot").rglob("*") if path.is_file())
    name = data.draw(st.sampled_from(names))
    content = bytearray((good / name).read_bytes())
    with copy_of(good) as artifact:
        if data.draw(st.booleans()):
            end = data.draw(st.integers(0, len(content) - 2))  # the last byte of a text is its line's end
            (artifact / name).write_bytes(content[:end])
            assert faults(artifact)
        else:
            for place in data.draw(st.lists(st.integers(0, len(content) - 1), min_size=1, max_size=5)):
                content[place] ^= data.draw(st.integers(1, 255))
            (artifact / name).write_bytes(content)
            check_lerobot(artifact / "lerobot")
