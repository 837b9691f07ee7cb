"""Datasets merged and split: nothing is lost, nothing is twice, kin stay together."""

import re
import shutil

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rendered_towel import ROBOT, write_rendered
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.dataset.check_provenance import check_provenance
from sim1.dataset.reshape import kindred, lerobot_root, merge, shared_out, split
from sim1.dataset.stage import DatasetConfig, check_dataset, dataset
from sim1.dataset.tables import column, read_tables
from sim1.stage import BadInput


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A dataset of four trajectories."""
    folder = tmp_path_factory.mktemp("reshape")
    out = folder / "whole"
    out.mkdir()
    rendered = write_rendered(folder / "towel", variants=1, frame_counts=(25, 28, 31, 22))
    dataset({"robot": ROBOT, "rendered_episodes": {"towel": rendered}}, out, DatasetConfig(keypoint_count=5))
    return out


def states(folder):
    """State of every episode, by its number."""
    tables = read_tables(lerobot_root(folder))
    return [column(part, "observation.state") for _, part in tables.frames.groupby("episode_index")]


def with_sources(made, folder, sources):
    shutil.copytree(made, folder)
    table = pd.read_parquet(folder / "provenance.parquet")
    table.assign(sources=sources).to_parquet(folder / "provenance.parquet", index=False)
    return folder


def test_parts_together_are_the_whole_and_kin_stay_together(made, tmp_path):
    kin = with_sources(made, tmp_path / "kin", [["a"], ["b"], ["a", "c"], ["d"]])
    counts = split(kin, {"train": 0.75, "test": 0.25}, tmp_path / "parts", seed=0)
    assert counts == {"train": 3, "test": 1}
    tables = {name: pd.read_parquet(tmp_path / "parts" / name / "provenance.parquet") for name in counts}
    used = {name: set(np.concatenate(table.sources.tolist())) for name, table in tables.items()}
    assert not used["train"] & used["test"]
    whole = dict(zip(pd.read_parquet(kin / "provenance.parquet").trajectory, states(kin), strict=True))
    for name, table in tables.items():
        assert table.episode_index.tolist() == list(range(counts[name]))
        for trajectory, episode in zip(table.trajectory, states(tmp_path / "parts" / name), strict=True):
            np.testing.assert_array_equal(episode, whole[trajectory])
        assert [finding.name for finding in check_provenance(tmp_path / "parts" / name) if not finding.passed] == []


def test_equal_names_of_two_garments_are_two_sources(made, tmp_path):
    kin = with_sources(made, tmp_path / "kin", [["0000"]] * 4)
    table = pd.read_parquet(kin / "provenance.parquet")
    table.assign(garment=["towel", "towel", "polo", "polo"]).to_parquet(kin / "provenance.parquet", index=False)
    assert split(kin, {"one": 0.5, "other": 0.5}, tmp_path / "parts", seed=0) == {"one": 2, "other": 2}


def test_merged_datasets_hold_all_episodes_in_order_with_their_provenance(made, tmp_path):
    assert merge([made, made], tmp_path / "twice") == 8
    np.testing.assert_array_equal(np.concatenate(states(tmp_path / "twice")), np.concatenate(states(made) * 2))
    table = pd.read_parquet(tmp_path / "twice" / "provenance.parquet")
    assert table.episode_index.tolist() == list(range(8))
    assert not (tmp_path / "twice.part").exists()


def test_trajectories_of_two_datasets_that_are_numbered_alike_are_told_apart_and_the_whole_passes_its_own_check(
    made, tmp_path
):
    merge([made, made], tmp_path / "twice")
    assert [finding.name for finding in check_dataset(tmp_path / "twice") if not finding.passed] == []
    table = pd.read_parquet(tmp_path / "twice" / "provenance.parquet")
    assert table.trajectory.tolist() == [f"{place}-{number:04d}" for place in (1, 2) for number in range(4)]
    assert table.sources.iloc[:4].map(list).tolist() == table.sources.iloc[4:].map(list).tolist()  # may be kin
    names = pd.read_parquet(made / "provenance.parquet").trajectory
    assert names.tolist() == [f"{number:04d}" for number in range(4)]


def test_parts_and_the_whole_have_the_keypoints_and_limits_of_what_they_come_from(made, tmp_path):
    split(made, {"one": 0.5, "other": 0.5}, tmp_path / "parts", seed=0)
    merge([tmp_path / "parts" / "one", tmp_path / "parts" / "other"], tmp_path / "again")
    for folder in (tmp_path / "parts" / "one", tmp_path / "again"):
        for name in ("keypoints.json", "limits.json"):
            assert (folder / name).read_text() == (made / name).read_text()
    again = pd.read_parquet(tmp_path / "again" / "provenance.parquet").trajectory
    assert sorted(again) == [f"{number:04d}" for number in range(4)]  # no two alike: called what they were


@pytest.mark.parametrize(
    ("name", "said"), [("keypoints.json", "another mesh"), ("limits.json", "only data of one robot")]
)
def test_another_mesh_under_a_garments_name_and_another_robot_are_refused(made, tmp_path, name, said):
    other = tmp_path / "other"
    shutil.copytree(made, other)
    (other / name).write_text(re.sub(r"(\[\s*)", r"\g<1>7, ", (made / name).read_text(), count=1))
    with pytest.raises(BadInput, match=said):
        merge([made, other], tmp_path / "out")
    (other / name).write_text("{")
    with pytest.raises(BadInput, match=f"{name}: damaged"):
        merge([made, other], tmp_path / "out")
    assert not list(tmp_path.glob("out*"))


def test_without_provenance_episodes_are_independent_and_merging_keeps_none(made, tmp_path):
    plain = tmp_path / "plain"
    shutil.copytree(made / "lerobot", plain)
    assert merge([made, plain], tmp_path / "both") == 8
    assert not (tmp_path / "both" / "provenance.parquet").exists()
    assert split(plain, {"one": 0.5, "other": 0.5}, tmp_path / "halves", seed=3) == {"one": 2, "other": 2}


def test_what_does_not_fit_is_refused_with_the_feature_and_nothing_is_left(made, tmp_path):
    rendered = write_rendered(tmp_path / "slow", variants=1, rate_hz=15)
    (tmp_path / "other").mkdir()
    dataset(
        {"robot": ROBOT, "rendered_episodes": {"towel": rendered}}, tmp_path / "other", DatasetConfig(keypoint_count=4)
    )
    with pytest.raises(BadInput, match=r"other: feature privileged\.garment_keypoints, fps: not as in"):
        merge([made, tmp_path / "other"], tmp_path / "out")
    assert not list(tmp_path.glob("out*"))


def test_a_damaged_dataset_is_refused_and_what_exists_is_not_overwritten(made, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(made, broken)
    (broken / "lerobot/meta/stats.json").write_text("{")
    with pytest.raises(BadInput, match="broken: tables_readable"):
        merge([made, broken], tmp_path / "out")
    with pytest.raises(BadInput, match=r"exists; give another folder"):
        merge([made, made], made)


def test_too_few_independent_episodes_for_the_parts_are_told(made, tmp_path):
    kin = with_sources(made, tmp_path / "kin", [["a"]] * 4)
    with pytest.raises(BadInput, match=r"1 groups .* test would be empty"):
        split(kin, {"train": 0.75, "test": 0.25}, tmp_path / "parts", seed=0)


@given(st.lists(st.sets(st.sampled_from("abcdefgh"), max_size=3), min_size=1, max_size=30), st.integers(0, 5))
def test_no_source_is_in_two_parts(sources, seed):
    sources = [sorted(one) for one in sources]
    groups = kindred(sources)
    parts = shared_out(groups, {"train": 0.7, "val": 0.2, "test": 0.1}, seed)
    assert sorted(episode for episodes in parts.values() for episode in episodes) == list(range(len(sources)))
    used = [{name for episode in episodes for name in sources[episode]} for episodes in parts.values()]
    assert len(set().union(*used)) == sum(map(len, used))


def test_the_command_says_what_is_wrong_and_ends_with_1(made, tmp_path):
    fine = CliRunner().invoke(app, ["dataset", "check", str(made)])
    assert fine.exit_code == 0
    assert "ok     videos_complete" in fine.stdout
    assert "ok     provenance_complete" in fine.stdout
    shutil.copytree(made / "lerobot", tmp_path / "cut")
    next((tmp_path / "cut").rglob("*.mp4")).write_bytes(b"")
    wrong = CliRunner().invoke(app, ["dataset", "check", str(tmp_path / "cut")])
    assert wrong.exit_code == 1
    assert "FAILED videos_complete" in wrong.stdout
    nothing = CliRunner().invoke(app, ["dataset", "check", str(tmp_path)])
    assert nothing.exit_code == 2
    assert "no LeRobot dataset" in nothing.stderr


def test_shares_that_make_no_sense_are_refused(made, tmp_path):
    for shares, said in (
        (["train=0.8"], "add up to 0.8"),
        (["train"], "expected PART=SHARE"),
        (["a b=1"], "name of its own"),
    ):
        options = [word for share in shares for word in ("--share", share)]
        answer = CliRunner().invoke(app, ["dataset", "split", str(made), "--out", str(tmp_path / "out"), *options])
        assert answer.exit_code == 2
        assert said in answer.stderr
