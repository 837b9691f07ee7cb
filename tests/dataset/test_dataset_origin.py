"""An episode that is not the one named is found, although all of them begin and end with the arms at home."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from folded_towel import CAMERAS, FRAMES, SHOWN, column_of, decided, fold, picture, rendered, written
from rendered_towel import ROBOT
from typer.testing import CliRunner

from assets_defs.cli import app
from sim1.dataset.check_source import check_source, sources_beside
from sim1.dataset.stage import DatasetConfig, check_dataset, dataset
from sim1.stage import BadInput


@pytest.fixture(scope="module")
def right(tmp_path_factory) -> Path:
    """Folder with `source`, rendered episodes from three cameras, and `out`, the dataset of them."""
    folder = tmp_path_factory.mktemp("origin")
    written(folder, rendered(folder / "source"))
    return folder


def failed(artifact: Path) -> list[str]:
    return [finding.name for finding in check_dataset(artifact) if not finding.passed]


def said_to_be(right: Path, folder: Path, **changed) -> Path:
    """A dataset of other episodes or pictures, sound in itself, that is said to be the right one."""
    wrong = written(folder, rendered(folder / "source", **changed))
    shutil.copy(right / "out" / "provenance.parquet", wrong / "provenance.parquet")
    return wrong


def backwards(frame_count: int, number: int):
    made = fold(frame_count, number)
    arrays = ("joints_rad", "openness", "command_joints_rad", "command_openness", "garment_m")
    return replace(made, **{name: getattr(made, name)[::-1] for name in arrays})


def test_three_cameras_go_through_writer_and_check(right):
    findings = check_dataset(right / "out")
    assert [finding for finding in findings if not finding.passed] == []
    features = json.loads((right / "out/lerobot/meta/info.json").read_text())["features"]
    assert {name for name in features if name.startswith("observation.images")} == {
        f"observation.images.{camera}" for camera in CAMERAS
    }
    shown = next(finding.detail for finding in findings if finding.name == "moments_match_pictures")
    assert shown.startswith("45 pictures of 3 cameras")
    assert check_source(right / "out", [right / "source"], all_there=True).passed


def test_the_episodes_are_like_real_ones_at_home_at_both_ends_and_hardly_different_there():
    for number in range(3):
        state = fold(FRAMES, number).state()
        np.testing.assert_allclose(state[0], state[-1], atol=1e-6)
        np.testing.assert_allclose(state[0], fold(FRAMES, 0).state()[0], atol=1e-6)
        ends = [picture(frame, number, 0, "head").astype(float) for frame in (0, SHOWN - 1)]
        assert 1.0 < np.abs(ends[0] - ends[1]).mean() < 3.0


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"make": lambda count, number: fold(count, {0: 1, 1: 0}.get(number, number))}, "episode 0"),
        ({"make": lambda count, number: (backwards if number == 2 else fold)(count, number)}, "episode 2"),
        ({"counts": (FRAMES, FRAMES - 6, FRAMES)}, "episode 1: 7 frames"),
    ],
    ids=["two exchanged", "one backwards", "one cut short"],
)
def test_states_of_another_episode_are_found_with_the_source_and_without(right, tmp_path, changed, said):
    wrong = said_to_be(right, tmp_path, **changed)
    findings = {finding.name: finding for finding in check_dataset(wrong)}
    assert not findings["moments_match_states"].passed
    assert said in findings["moments_match_states"].detail
    by_source = check_source(wrong, [right / "source"], all_there=True)
    assert not by_source.passed
    assert said in by_source.detail


def other_way(only: int, camera: str):
    def paint(frame: int, number: int, variant: int, name: str):
        turned = number == only and name == camera
        return picture(SHOWN - 1 - frame if turned else frame, number, variant, name)

    return paint


def exchanged(frame: int, number: int, variant: int, name: str):
    return picture(frame, {0: 1, 1: 0}.get(number, number) if name == "right_wrist" else number, variant, name)


@pytest.mark.parametrize(
    ("paint", "said"),
    [
        (other_way(1, "head"), "episode 1, frame 0 of head: "),
        (other_way(2, "left_wrist"), "episode 2, frame 0 of left_wrist: "),
        (exchanged, "episode 0, frame 0 of right_wrist: "),
    ],
    ids=["one backwards", "one backwards from a wrist", "two exchanged in one look"],
)
def test_pictures_of_other_moments_are_found_from_every_camera(right, tmp_path, paint, said):
    wrong = said_to_be(right, tmp_path, paint=paint)
    findings = {finding.name: finding for finding in check_dataset(wrong) if not finding.passed}
    assert list(findings) == ["moments_match_pictures"]
    assert said in findings["moments_match_pictures"].detail
    assert "of the way to frame" in findings["moments_match_pictures"].detail


def test_what_lies_between_the_moments_that_provenance_keeps_is_held_to_the_source(right, tmp_path):
    def nudged(count: int, number: int):
        made = fold(count, number)
        joints = made.joints_rad.copy()
        joints[3, 0, 2] += 0.01  # shown as frame 1; kept are 0, 2, 4, 6, 8
        return replace(made, joints_rad=joints) if number == 1 else made

    wrong = said_to_be(right, tmp_path, make=nudged)
    assert failed(wrong) == []
    said = check_source(wrong, [right / "source"], all_there=True)
    assert not said.passed
    assert "observation.state of data/chunk-000/file-000.parquet row 10 is 0.01 off frame 3" in said.detail


def test_the_command_compares_with_sources_that_are_named_or_lie_beside(right, tmp_path):
    def run(*arguments: str):
        return CliRunner().invoke(app, ["dataset", "check", *arguments])

    artifact = str(right / "out")
    assert "frames_match_source" not in run(artifact).stdout
    assert "ok     frames_match_source: 3 episodes\n" in run(artifact, "--episodes", str(right / "source")).stdout
    (tmp_path / "empty").mkdir()
    other = run(artifact, "--episodes", str(tmp_path / "empty"))
    assert other.exit_code == 1
    assert "is the one that it was made from (towel, 0000); name the folder" in " ".join(other.stdout.split())
    assert run(artifact, "--episodes", str(tmp_path / "none")).exit_code == 2
    # In a store; an episode that was made anew since is no fault of the dataset.
    shutil.copytree(right / "out", tmp_path / "store/dataset/_")
    shutil.copytree(right / "source", tmp_path / "store/rendered_episodes/towel")
    assert sources_beside(tmp_path / "store/dataset/_") == [tmp_path / "store/rendered_episodes"]
    assert "ok     frames_match_source: 3 episodes\n" in run(str(tmp_path / "store/dataset/_")).stdout
    (tmp_path / "store/rendered_episodes/towel/episodes/0001/episode.npz").write_bytes(b"new")
    assert (
        "frames_match_source: 2 episodes; 1 whose files were not found" in run(str(tmp_path / "store/dataset/_")).stdout
    )


def test_provenance_holds_what_judge_and_filters_said(right):
    first, _, last = column_of(right / "out", "scores")
    assert first["figures"] == {"iou": 0.9}
    assert (first["success"], first["rules_pass"], first["accepted"]) == (True, True, True)
    assert (first["video_score"], first["video_pass"], first["video_abstains"]) == (0.5, True, False)
    assert (last["video_score"], last["video_pass"], last["video_abstains"]) == (None, None, True)


def test_an_episode_that_nobody_decided_on_and_decisions_without_a_column_are_named(right, tmp_path):
    folder = decided(tmp_path / "decided")
    inputs = {"robot": ROBOT, "rendered_episodes": {"towel": right / "source"}, "valid_trajectories": {"towel": folder}}
    table = pd.read_parquet(folder / "decisions.parquet")
    table.iloc[1:].to_parquet(folder / "decisions.parquet")
    with pytest.raises(BadInput, match=r"episodes/0000: rendered, but valid_trajectories decided on no episode"):
        dataset(inputs, tmp_path / "one", DatasetConfig(keypoint_count=4))
    table.drop(columns="video_score").to_parquet(folder / "decisions.parquet")
    with pytest.raises(BadInput, match=r"decisions\.parquet: no column video_score; make valid_trajectories again"):
        dataset(inputs, tmp_path / "two", DatasetConfig(keypoint_count=4))
