"""States and actions of an episode at rates below its own."""

import numpy as np
import pytest

from sim1.episode import RATE_HZ, Episode


def obedient(frame_count: int) -> Episode:
    """Arms and grippers that are in every frame where they were told to be in the frame before."""
    stream = np.random.default_rng(4)
    joints, openness = stream.uniform(-1, 1, (frame_count + 1, 2, 6)), stream.uniform(0, 1, (frame_count + 1, 2))
    return Episode(
        time_s=np.arange(frame_count) / RATE_HZ,
        joints_rad=joints[:-1],
        openness=openness[:-1],
        command_joints_rad=joints[1:],
        command_openness=openness[1:],
        garment_m=np.zeros((frame_count, 3, 3)),
    )


@pytest.mark.parametrize("stride", [1, 3, 6])
@pytest.mark.parametrize("frame_count", [19, 20, 24])
def test_following_an_action_leads_to_the_next_state_that_is_kept(stride, frame_count):
    episode = obedient(frame_count)
    states, actions = episode.state()[::stride], episode.action_until_next(stride)
    assert len(actions) == len(states)
    np.testing.assert_array_equal(actions[:-1], states[1:])
    np.testing.assert_array_equal(actions[-1], episode.action()[-1])
