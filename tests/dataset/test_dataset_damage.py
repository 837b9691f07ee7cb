"""The check finds what was done to a dataset, and names it."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from damaged_towel import EPISODES, FRAMES, VIDEO, change_json, change_table, cut, only_file, set_cell
from rendered_towel import ROBOT, write_rendered

from sim1.dataset.check import check_lerobot
from sim1.dataset.stage import DatasetConfig, check_dataset, dataset


def failures(artifact: Path) -> list[str]:
    return [finding.name for finding in check_dataset(artifact) if not finding.passed]


DAMAGE = {
    "a state that is not a number": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 3, "observation.state", np.nan, 2)),
        "values_finite",
    ),
    "a joint beyond this robot's limit, of half a turn for other arms": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 3, "observation.state", 1.7, index=4)),
        "joints_within_limits",
    ),
    "a joint beyond its limit": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 3, "action", 4.0, 1)),
        "joints_within_limits",
    ),
    "a gripper more than open": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 3, "observation.state", 1.5, 6)),
        "joints_within_limits",
    ),
    "a time stamp off the grid": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 4, "timestamp", 0.42)),
        "timestamps_on_grid",
    ),
    "a row left out": (lambda a: change_table(only_file(a, FRAMES), lambda t: t.drop(index=5)), "indices_run_on"),
    "a column left out": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: t.drop(columns="action")),
        "tables_readable",
    ),
    "two rows exchanged": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: t.iloc[[1, 0, *range(2, len(t))]]),
        "indices_run_on",
    ),
    "frames of an unknown task": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 0, "task_index", 7)),
        "tasks_known",
    ),
    "a state changed after the statistics were made": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 0, "observation.state", 3.0, 0)),
        "statistics_true",
    ),
    "the first state of another trajectory": (
        lambda a: change_table(only_file(a, FRAMES), lambda t: set_cell(t, 7, "observation.state", 0.5, 3)),
        "moments_match_states",
    ),
    "an episode said to start elsewhere": (
        lambda a: change_table(only_file(a, EPISODES), lambda t: set_cell(t, 1, "dataset_from_index", 6)),
        "indices_run_on",
    ),
    "an episode said to be elsewhere in the video": (
        lambda a: change_table(
            only_file(a, EPISODES), lambda t: set_cell(t, 1, "videos/observation.images.head/from_timestamp", 0.3)
        ),
        "videos_complete",
    ),
    "counts that are wrong": (lambda a: change_json(a / "lerobot/meta/info.json", total_frames=99), "counts_agree"),
    "an older format": (
        lambda a: change_json(a / "lerobot/meta/info.json", codebase_version="v2.1"),
        "tables_readable",
    ),
    "an info file that is cut off": (lambda a: cut(a / "lerobot/meta/info.json"), "tables_readable"),
    "a table that is cut off": (lambda a: cut(only_file(a, FRAMES)), "tables_readable"),
    "a video that is cut off": (lambda a: cut(only_file(a, VIDEO)), "videos_complete"),
    "a video that is missing": (lambda a: only_file(a, VIDEO).unlink(), "videos_complete"),
    "provenance that is missing": (lambda a: (a / "provenance.parquet").unlink(), "provenance_complete"),
    "an episode without provenance": (
        lambda a: change_table(a / "provenance.parquet", lambda t: t.iloc[:1]),
        "provenance_complete",
    ),
}


@pytest.mark.parametrize("what", DAMAGE)
def test_damage_is_found_in(artifact, what):
    damage, finding = DAMAGE[what]
    damage(artifact)
    assert finding in failures(artifact)


def test_pictures_of_other_states_are_found(artifact, tmp_path):
    """The same states, with the pictures in the opposite order."""
    other = write_rendered(tmp_path / "towel")
    for clip in other.glob("episodes/*/v0/head"):
        frames = sorted(clip.glob("*.png"))
        pictures = [frame.read_bytes() for frame in frames]
        for frame, picture in zip(frames, reversed(pictures)):
            frame.write_bytes(picture)
    (tmp_path / "turned").mkdir()
    dataset(
        {"robot": ROBOT, "rendered_episodes": {"towel": other}}, tmp_path / "turned", DatasetConfig(keypoint_count=4)
    )
    shutil.copy(only_file(tmp_path / "turned", VIDEO), only_file(artifact, VIDEO))
    assert failures(artifact) == ["moments_match_pictures"]


def test_the_check_needs_nothing_of_this_project(good):
    """Any LeRobot dataset can be checked: without limits, provenance or keypoints."""
    findings = check_lerobot(good / "lerobot")
    assert [finding.name for finding in findings if not finding.passed] == []
    assert "joints_within_limits" not in [finding.name for finding in findings]
