"""Errors of an image policy on held-out trajectories, and what intervals they have."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import torch
from painted_world import Painter, write_world

from sim1.policy.image.build import Trained
from sim1.policy.image.clips import split_clips
from sim1.policy.image.evaluation import errors_of, without_pictures
from sim1.policy.image.measures import BLANK, DATASET, measure
from sim1.policy.image.shifts import IN_DOMAIN


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """A dataset of painted pictures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim1.render.blender.run_blender", Painter())
        return write_world(tmp_path_factory.mktemp("world"))["dataset"][""]


def test_intervals_are_over_demonstrations_and_changes_are_paired():
    stream = np.random.default_rng(0)
    level = stream.uniform(0.1, 0.5, 6)  # trajectories differ by far more than a look changes
    rows = [
        {"seed": seed, "pictures": name, "garment": "towel", "trajectory": str(place), "source": str(place),
         "appearance": appearance, "joint_error_rad": own + more, "openness_error": 0.1,
         "hold_joint_error_rad": 0.2, "hold_openness_error": 0.1}
        for name, more, copies in ((DATASET, 0.0, 2), (IN_DOMAIN, 0.0, 1), ("lighting", 0.02, 1), (BLANK, 0.3, 1))
        for place, own in enumerate(level)
        for appearance in range(copies)
        for seed in (3, 5)
    ]  # fmt: skip
    points = {point.pictures: point for point in measure(pd.DataFrame(rows), seed=0)}
    assert list(points) == [DATASET, IN_DOMAIN, "lighting", BLANK]
    counts = points[DATASET].trajectory_count, points[DATASET].source_count, points[DATASET].clip_count
    assert counts == (6, 6, 12)
    half = 2.571 * level.std(ddof=1) / np.sqrt(6)  # Student's
    np.testing.assert_allclose(
        points[DATASET].joint_rad.interval, (level.mean() - half, level.mean() + half), atol=0.01
    )
    np.testing.assert_allclose(points["lighting"].joint_change_rad.interval, (0.02, 0.02), atol=1e-9)
    np.testing.assert_allclose(points["lighting"].openness_change.interval, (0.0, 0.0), atol=1e-9)
    assert points[IN_DOMAIN].joint_change_rad is None
    one = measure(pd.DataFrame(rows)[lambda table: table["trajectory"] == "0"], seed=0)
    assert one[0].joint_rad.interval is None
    kin = measure(pd.DataFrame(rows).assign(source="0003"), seed=0)
    assert (kin[0].trajectory_count, kin[0].source_count, kin[0].joint_rad.interval) == (6, 1, None)
    assert kin[2].joint_change_rad.interval is None


def test_networks_that_differ_widen_the_interval_and_not_that_of_a_change_which_all_of_them_show():
    def points(spread):
        rows = [
            {"seed": seed, "pictures": name, "garment": "towel", "trajectory": str(place), "source": str(place),
             "appearance": 0,
             "joint_error_rad": 0.2 + 0.001 * place + spread * seed + more, "openness_error": 0.1, "hold_joint_error_rad": 0.2,
             "hold_openness_error": 0.1}
            for name, more in ((IN_DOMAIN, 0.0), ("lighting", 0.02))
            for place in range(6)
            for seed in range(5)
        ]  # fmt: skip
        return {point.pictures: point for point in measure(pd.DataFrame(rows), seed=0)}

    alike, apart = points(0.0), points(0.01)
    width = [
        found[IN_DOMAIN].joint_rad.interval.high - found[IN_DOMAIN].joint_rad.interval.low for found in (alike, apart)
    ]
    assert width[1] > 3 * width[0] > 0
    assert (apart[IN_DOMAIN].trajectory_count, apart[IN_DOMAIN].clip_count) == (6, 6)
    np.testing.assert_allclose(apart["lighting"].joint_change_rad.interval, (0.02, 0.02), atol=1e-9)


class Parrot(torch.nn.Module):
    """A policy that commands the arms to stay where they are; remembers what it saw."""

    def __init__(self, config):
        super().__init__()
        self.config, self.seen = config, []

    def reset(self):
        pass

    def predict_action_chunk(self, batch):
        self.seen.append(batch)
        return batch["observation.state"][:, None].repeat(1, 7, 1)


@pytest.fixture
def parrot():
    features = dict.fromkeys(("observation.images.head", "observation.state"))
    config = SimpleNamespace(
        input_features=features, observation_delta_indices=None, action_delta_indices=[0, 1], reward_delta_indices=None
    )
    return Trained(policy=Parrot(config), prepare=lambda batch: batch, restore=lambda chunk: chunk)


def errors_on(data, parrot, **changes):
    how = {"chunk_frames": 5, "every": 1, "batch": 4, "workers": 0, "seed": 0, **changes}
    return errors_of(parrot, data, {DATASET: split_clips(data, 0.25, 0).held_out}, **how)


def test_a_policy_that_stands_still_has_the_error_of_standing_still(data, parrot):
    rows = errors_on(data, parrot)
    assert len(rows) == 2
    for row in rows:
        assert row["joint_error_rad"] == pytest.approx(row["hold_joint_error_rad"], abs=1e-6) != 0
        assert row["openness_error"] == pytest.approx(row["hold_openness_error"], abs=1e-6)
    names = {name for batch in parrot.policy.seen for name in batch}
    assert names == {"observation.images.head", "observation.state", "task"}  # no keypoints, no answers


def test_without_pictures_a_policy_sees_one_colour_and_all_else(data, parrot):
    color = np.array([0.1, 0.2, 0.3], np.float32).reshape(3, 1, 1)
    errors_on(data, parrot, see=without_pictures({"observation.images.head": color}))
    for batch in parrot.policy.seen:
        picture = batch["observation.images.head"]
        assert picture.shape[-2:] == (24, 32)
        assert torch.equal(picture, torch.from_numpy(color).expand_as(picture))
        assert batch["observation.state"].std() > 0
