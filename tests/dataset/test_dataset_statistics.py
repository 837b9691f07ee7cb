"""The check holds stored statistics against the data, feature by feature, of the whole and of every episode."""

import json
from pathlib import Path

import numpy as np
import pytest
from damaged_towel import EPISODES, change_table, only_file
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sim1.dataset.check_statistics import check_statistics
from sim1.dataset.tables import plain, read_tables

PICTURES = "observation.images.head"
NUMBERS = ("observation.state", "action", "privileged.garment_keypoints", "timestamp", "frame_index")


def said_of(artifact: Path) -> str:
    """What the check finds wrong; empty where it passes."""
    finding = check_statistics(read_tables(artifact / "lerobot"))
    return "" if finding.passed else finding.detail


def change_whole(artifact: Path, name: str, key: str, change) -> None:
    path = artifact / "lerobot/meta/stats.json"
    stats = json.loads(path.read_text())
    stats[name][key] = change(np.array(stats[name][key])).tolist()
    path.write_text(json.dumps(stats))


def change_episode(artifact: Path, row: int, name: str, key: str, change) -> None:
    def changed(table):
        column = f"stats/{name}/{key}"
        table[column] = [change(np.array(plain(v))).tolist() if n == row else v for n, v in enumerate(table[column])]

    change_table(only_file(artifact, EPISODES), changed)


def test_what_was_written_is_true(good):
    assert said_of(good) == ""


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("key", ["min", "max", "mean", "std", "count"])
def test_a_number_changed_in_the_whole_is_named_with_its_feature_and_place(artifact, name, key):
    change_whole(artifact, name, key, lambda value: value * 1.25 + 1)
    where = f"meta/stats.json: {name}: {key}"
    assert where in said_of(artifact)


@pytest.mark.parametrize("name", NUMBERS)
@pytest.mark.parametrize("key", ["min", "max", "mean", "std", "count"])
def test_a_number_changed_in_an_episode_is_named_with_its_feature_and_episode(artifact, name, key):
    change_episode(artifact, 1, name, key, lambda value: value * 1.25 + 1)
    said = said_of(artifact)
    assert f"meta/episodes: episode 1: {name}: {key}" in said
    assert "episode 0" not in said


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.sampled_from(NUMBERS[:3]),
    key=st.sampled_from(["min", "max", "mean"]),
    place=st.integers(0, 11),
    share=st.floats(0.002, 10.0),
    sign=st.sampled_from([-1, 1]),
)
def test_one_value_that_is_off_by_a_part_in_five_hundred_of_the_largest_is_named(good, name, key, place, share, sign):
    tables = read_tables(good / "lerobot")
    values = np.array(tables.stats[name][key])
    values[place] += sign * share * np.abs([tables.stats[name]["min"], tables.stats[name]["max"]]).max()
    changed = {**tables.stats, name: {**tables.stats[name], key: values.tolist()}}
    finding = check_statistics(type(tables)(**{**vars(tables), "stats": changed}))
    assert not finding.passed
    assert f"meta/stats.json: {name}: {key}[{place}]" in finding.detail


@pytest.mark.parametrize("key", ["min", "max", "mean", "std", "count"])
def test_a_statistic_that_is_left_out_is_named(artifact, key):
    path = artifact / "lerobot/meta/stats.json"
    stats = json.loads(path.read_text())
    del stats["action"][key]
    path.write_text(json.dumps(stats))
    change_table(only_file(artifact, EPISODES), lambda table: table.drop(columns=f"stats/observation.state/{key}"))
    said = said_of(artifact)
    assert f"meta/stats.json: action: no {key}" in said
    assert f"meta/episodes: episode 0: observation.state: no {key}" in said


def test_a_feature_without_statistics_is_named(artifact):
    path = artifact / "lerobot/meta/stats.json"
    path.write_text(json.dumps({name: one for name, one in json.loads(path.read_text()).items() if name != "action"}))
    assert "meta/stats.json: no action" in said_of(artifact)


@pytest.mark.parametrize(
    ("key", "change", "said"),
    [
        ("mean", lambda value: value * 255, "not between min and max"),
        ("max", lambda value: value * 255, "expected within 0 to 1"),
        ("std", lambda value: value * 10, "no values from min to max have that"),
        ("count", lambda value: value * 0, "count is 0"),
        ("q50", lambda value: value + 0.6, "above"),
    ],
)
def test_pictures_statistics_have_the_shape_and_range_of_pictures(artifact, key, change, said):
    change_episode(artifact, 1, PICTURES, key, change)
    found = said_of(artifact)
    assert f"meta/episodes: episode 1: {PICTURES}: " in found
    assert said in found


@pytest.mark.parametrize("key", ["min", "max", "mean", "std", "count"])
def test_pictures_statistics_of_the_whole_are_those_of_the_episodes_together(artifact, key):
    change_whole(artifact, PICTURES, key, lambda value: value * 0.99 if key != "count" else value + 1)
    assert f"meta/stats.json: {PICTURES}: {key} is" in said_of(artifact)


def test_a_value_that_is_no_number_is_named(artifact):
    path = artifact / "lerobot/meta/stats.json"
    stats = json.loads(path.read_text())
    stats["action"]["mean"][3] = "wide"
    stats["observation.state"]["std"][2] = float("nan")
    path.write_text(json.dumps(stats))
    said = said_of(artifact)
    assert "meta/stats.json: action: mean is" in said
    assert "meta/stats.json: observation.state: std is" in said


def test_statistics_of_another_shape_than_the_feature_are_named(artifact):
    change_whole(artifact, PICTURES, "mean", lambda value: value[:, 0, 0])
    change_whole(artifact, "action", "std", lambda value: value[:5])
    said = said_of(artifact)
    assert f"meta/stats.json: {PICTURES}: mean has shape (3,), expected (3, 1, 1)" in said
    assert "meta/stats.json: action: std has shape (5,), expected (14,)" in said
