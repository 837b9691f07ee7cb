"""Joint speeds of generated episodes are checked as they are stored, against the arm's limits."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from motion_synthetic import HOME

from sim1.episode import RATE_HZ, Episode, write_episode
from sim1.motion.generation import fastest_share, write_limits
from sim1.motion.stage import check_candidate_trajectories

FRAMES = 6


def moving(share, limit_rad_s, joint=3) -> Episode:
    """The left arm's joint turns evenly at that share of its limit, in commands and in what was measured a frame later."""
    way = np.repeat(HOME[None], FRAMES + 1, axis=0)
    way[:, 0, joint] += np.arange(FRAMES + 1) * share * limit_rad_s[joint] / RATE_HZ
    return Episode(
        time_s=np.arange(FRAMES) / RATE_HZ,
        joints_rad=way[:-1],
        openness=np.ones((FRAMES, 2)),
        command_joints_rad=way[1:],
        command_openness=np.ones((FRAMES, 2)),
        garment_m=np.zeros((FRAMES, 4, 3)),
    )


def joint_speeds(folder, episode, arms):
    write_episode(folder / "episodes" / "0000", episode)
    write_limits(folder, arms)
    # The writer's own share says that all is well.
    row = {"episode": "0000", "ran": True, "success": True, "failure": None, "speed_share": 0.5}
    pd.DataFrame([row]).to_parquet(folder / "attempts.parquet", index=False)
    [finding] = [item for item in check_candidate_trajectories(folder) if item.name == "joint_speeds"]
    return finding


@pytest.mark.parametrize(("share", "passed"), [(0.9, True), (1.0, True), (1.2, False)])
def test_a_joint_that_is_too_fast_in_a_stored_episode_is_found_whatever_its_writer_says(tmp_path, arms, share, passed):
    finding = joint_speeds(tmp_path, moving(share, arms.arm.velocity_limit_rad_s), arms)
    assert finding.blocking
    assert finding.passed is passed
    assert f"{share:.2f} times its limit in episode 0000" in finding.detail


@pytest.mark.parametrize("name", ["joints_rad", "command_joints_rad"])
def test_a_jump_of_what_was_commanded_and_of_what_was_measured_is_seen(arms, name):
    limit_rad_s = arms.arm.velocity_limit_rad_s
    still = moving(0.0, limit_rad_s)
    jumped = getattr(still, name).copy()
    jumped[3:, 1, 0] += 2 * limit_rad_s[0] / RATE_HZ
    assert fastest_share(still, limit_rad_s) == 0
    assert fastest_share(replace(still, **{name: jumped}), limit_rad_s) == pytest.approx(2)


def test_the_first_command_counts_from_where_the_arms_stood(arms):
    limit_rad_s = arms.arm.velocity_limit_rad_s
    away = moving(0.0, limit_rad_s)
    ahead = away.command_joints_rad + 3 * limit_rad_s / RATE_HZ
    assert fastest_share(replace(away, command_joints_rad=ahead), limit_rad_s) == pytest.approx(3)
