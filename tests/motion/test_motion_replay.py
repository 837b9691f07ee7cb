"""An episode beside its replay, bit for bit."""

from dataclasses import replace

import numpy as np
import pytest

from sim1.episode import Episode
from sim1.motion.replay import compared


@pytest.fixture
def episode() -> Episode:
    rng = np.random.default_rng(2)
    return Episode(
        time_s=np.arange(9) / 30,
        joints_rad=rng.random((9, 2, 6)),
        openness=rng.random((9, 2)),
        command_joints_rad=rng.random((9, 2, 6)),
        command_openness=rng.random((9, 2)),
        garment_m=rng.random((9, 4, 3)).astype(np.float32),
    )


def test_equal_bytes_are_the_same(episode):
    found = compared("0003", episode, episode)
    assert found.same
    assert found.said() == "0003: 9 frames again, the same bytes"


def test_the_last_bit_of_one_number_is_a_difference_with_its_frame(episode):
    garment = episode.garment_m.copy()
    garment[5, 2, 1] = np.nextafter(garment[5, 2, 1], np.float32(2))
    found = compared("0003", episode, replace(episode, garment_m=garment))
    assert not found.same
    assert (found.differing, found.frame) == ("garment_m", 5)
    assert found.largest == pytest.approx(6e-8, rel=0.5)


def test_the_array_that_differs_first_in_time_is_named(episode):
    joints, garment = episode.joints_rad + 0, episode.garment_m + 0
    garment[2:] += 1
    joints[4:] += 1
    assert compared("a", episode, replace(episode, joints_rad=joints, garment_m=garment)).differing == "garment_m"
    joints[1:] += 1
    assert compared("a", episode, replace(episode, joints_rad=joints, garment_m=garment)).differing == "joints_rad"


def test_an_episode_that_ends_sooner_is_not_the_same(episode):
    names = ("time_s", "joints_rad", "openness", "command_joints_rad", "command_openness", "garment_m")
    short = replace(episode, **{name: getattr(episode, name)[:7] for name in names})
    found = compared("a", episode, short)
    assert not found.same
    assert "7 frames in place of 9" in found.said()
