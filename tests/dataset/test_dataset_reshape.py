"""Datasets merged and split: nothing is lost, nothing is twice, kin stay together."""

import copy
import json
import re
import shutil

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rendered_towel import ROBOT, write_rendered, written_dataset
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.dataset.check_provenance import check_provenance
from sim1.dataset.reshape import kindred, lerobot_root, merge, shared_out, split, unlike
from sim1.dataset.stage import DatasetConfig, check_dataset, dataset
from sim1.dataset.tables import column, read_tables
from sim1.stage import BadInput, Finding


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A dataset of four trajectories."""
    return written_dataset(tmp_path_factory.mktemp("reshape"), (25, 28, 31, 22))


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
    with pytest.raises(BadInput) as said:
        merge([made, tmp_path / "other"], tmp_path / "out")
    assert str(said.value).startswith(f"{tmp_path / 'other'}: not like {made}: fps is 15, there 10; ")
    assert "feature privileged.garment_keypoints: shape is [12], there [15]" in str(said.value)
    assert not list(tmp_path.glob("out*"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda features: features["action"]["names"].__setitem__(2, "elbow"),
            "action: names has 'elbow' at place 2, there",
        ),
        (lambda features: features["action"].update(names=None), "action: names is None, there ['left_joint_1_rad'"),
        (lambda features: features.update(heat=dict(features["timestamp"])), "feature heat is only there"),
        (lambda features: features["action"].update(unit="deg"), "action: unit is 'deg', there None"),
    ],
)
def test_features_that_differ_are_refused_with_both_datasets_the_feature_and_what_to_do(made, change, said):
    info = json.loads((made / "lerobot/meta/info.json").read_text())
    other = copy.deepcopy(info)
    change(other["features"])
    assert unlike(info, info) == []
    (found,) = unlike(info, other) if "only there" in said else unlike(other, info)
    assert said in found


def test_names_that_differ_are_refused_before_anything_is_written(made, tmp_path):
    renamed = tmp_path / "renamed"
    shutil.copytree(made, renamed)
    path = renamed / "lerobot/meta/info.json"
    path.write_text(path.read_text().replace("left_joint_1_rad", "shoulder"))
    answer = CliRunner().invoke(app, ["dataset", "merge", str(made), str(renamed), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 2
    for part in (str(made), str(renamed), "feature action: names has 'shoulder'", "remove_feature"):
        assert part in answer.stderr.replace("\n", " ")
    assert not list(tmp_path.glob("out*"))


def test_a_merge_that_comes_out_unsound_is_told_and_not_put_in_place(made, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "sim1.dataset.reshape.check_lerobot",
        lambda root: [Finding(name="indices", passed=tmp_path not in root.parents, detail="index 3 comes twice")],
    )
    answer = CliRunner().invoke(app, ["dataset", "merge", str(made), str(made), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 2
    said = answer.stderr.replace("\n", " ")
    assert "indices: index 3 comes twice; nothing was put in place" in said
    assert "sim1 doctor" in said
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("error", [RuntimeError("disk"), KeyboardInterrupt()])
def test_nothing_is_left_of_a_merge_or_split_that_fails_or_is_interrupted(made, tmp_path, monkeypatch, error):
    def failing(*_, output_dir, **__):
        output_dir.mkdir()
        raise error

    monkeypatch.setattr("lerobot.datasets.dataset_tools.merge_datasets", failing)
    monkeypatch.setattr("lerobot.datasets.dataset_tools.split_dataset", failing)
    with pytest.raises(type(error)):
        merge([made, made], tmp_path / "out")
    with pytest.raises(type(error)):
        split(made, {"one": 0.5, "other": 0.5}, tmp_path / "out", seed=0)
    assert not list(tmp_path.iterdir())


def test_videos_that_do_not_go_into_one_file_are_told(made, tmp_path, monkeypatch):
    def failing(*_, output_dir, **__):
        output_dir.mkdir()
        raise ValueError("Input video b.mp4 is not compatible with the reference video a.mp4.")

    monkeypatch.setattr("lerobot.datasets.dataset_tools.merge_datasets", failing)
    with pytest.raises(BadInput, match=r"LeRobot cannot merge them: Input video b\.mp4"):
        merge([made, made], tmp_path / "out")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda table: table.iloc[:3], r"provenance\.parquet: rows of episodes \[0, 1, 2\], the dataset has 0 to 3"),
        (lambda table: table.drop(columns="sources"), r"provenance\.parquet: no column sources"),
    ],
)
def test_provenance_of_other_episodes_is_refused(made, tmp_path, damage, said):
    other = tmp_path / "other"
    shutil.copytree(made, other)
    damage(pd.read_parquet(other / "provenance.parquet")).to_parquet(other / "provenance.parquet", index=False)
    with pytest.raises(BadInput, match=said):
        split(other, {"one": 0.5, "other": 0.5}, tmp_path / "parts", seed=0)
    with pytest.raises(BadInput, match=said):
        merge([made, other], tmp_path / "parts")
    answer = CliRunner().invoke(app, ["dataset", "check", str(other)])
    assert answer.exit_code == 1
    assert "FAILED provenance_complete" in answer.stdout
    assert not list(tmp_path.glob("parts*"))


def test_a_place_that_cannot_be_written_to_is_told(made, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match=r"cannot be made \(Not a directory\)"):
        merge([made, made], tmp_path / "file" / "out")


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
