"""Demonstrations that a person gave: a LeRobot dataset of commands, followed in the cell."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim1.episode import STATE_NAMES, Episode, read_episode
from sim1.robot.session import shortened
from sim1.robot.stage import SeedDemosConfig, check_seed_demos, seed_demos
from sim1.robot.teleoperation import read_commands
from sim1.stage import BadInput


def as_lerobot(folder: Path, episodes: list[Episode], rate_hz: int = 30) -> Path:
    """A LeRobot dataset without pictures, as somebody would record who teleoperates."""
    from lerobot.datasets.lerobot_dataset import LeRobotDataset

    numbers = {"dtype": "float32", "shape": (14,), "names": STATE_NAMES}
    features = {"action": numbers, "observation.state": numbers}
    made = LeRobotDataset.create("me/teleoperated", fps=rate_hz, features=features, root=folder, use_videos=False)
    stride = round(30 / rate_hz)
    for episode in episodes:
        rows = zip(episode.action_until_next(stride), episode.state()[::stride], strict=True)
        for action, state in rows:
            made.add_frame({"action": action, "observation.state": state, "task": "fold it"})
        made.save_episode()
    made.finalize()
    return folder


def test_a_persons_commands_are_followed_in_place_of_the_experts(artifact, inputs, tmp_path):
    """The expert's own, handed over as a person's would be."""
    episode = read_episode(artifact[0] / "episodes" / f"{artifact[1]['attempt_count'] - 1:04d}")
    start = shortened(episode, 1.0)
    given = as_lerobot(tmp_path / "towel", [start, episode])
    config = SeedDemosConfig(demo_count=1, attempts=1, substeps=6, iterations=4, replay_s=1.0)
    (tmp_path / "out").mkdir()
    facts = seed_demos({**inputs, "demonstrations": {"towel": given}}, tmp_path / "out", config)
    assert facts["commands_by"] == "a person"
    assert "stand_in" not in facts
    assert [row["success"] for row in facts["attempts"]] == [False, True]  # all of them, not until enough succeeded
    again = read_episode(tmp_path / "out" / "episodes" / "0001")
    assert again.about["commands_of"] == "towel, episode 1"
    np.testing.assert_allclose(again.command_joints_rad[: episode.frame_count], episode.command_joints_rad, atol=1e-5)
    assert not [finding for finding in check_seed_demos(tmp_path / "out") if finding.blocking and not finding.passed]
    assert artifact[1]["commands_by"] == "a scripted expert"


def test_commands_of_a_lower_rate_lead_through_the_same_states_at_the_same_times(artifact, tmp_path):
    episode = read_episode(artifact[0] / "episodes" / "0000")
    [commands] = read_commands(as_lerobot(tmp_path / "towel", [episode], rate_hz=10))
    for given, told in (
        (episode.command_joints_rad, commands.joints_rad),
        (episode.command_openness, commands.openness),
    ):
        kept = min(len(given), len(told)) // 3 * 3
        np.testing.assert_allclose(told[2:kept:3], given[2:kept:3], atol=1e-5)
    np.testing.assert_allclose(commands.start_joints_rad, episode.joints_rad[0], atol=1e-5)


def test_demonstrations_that_cannot_be_followed_are_refused_with_their_place(artifact, tmp_path):
    short = shortened(read_episode(artifact[0] / "episodes" / "0000"), 0.4)
    wide = replace(short, command_openness=3.0 * np.ones_like(short.command_openness))
    with pytest.raises(BadInput, match=r"towel, episode 0: openness from .* to 3, expected 0 \(closed\) to 1"):
        read_commands(as_lerobot(tmp_path / "wide" / "towel", [wide]))
    lost = short.command_joints_rad.copy()
    lost[3, 1, 2] = np.nan
    with pytest.raises(BadInput, match=r"episode 0: right_joint_3_rad is nan at frame 3"):
        read_commands(as_lerobot(tmp_path / "lost" / "towel", [replace(short, command_joints_rad=lost)]))
    other = as_lerobot(tmp_path / "other" / "towel", [short])
    info = other / "meta" / "info.json"
    info.write_text(info.read_text().replace("left_joint_1_rad", "left_joint_1_deg"))
    with pytest.raises(BadInput, match=r"info\.json: action is \['left_joint_1_deg'"):
        read_commands(other)
    with pytest.raises(BadInput, match="no LeRobot dataset"):
        read_commands(tmp_path)
