import hashlib
from dataclasses import replace

import numpy as np
import pytest
import torch

from sim1.policy.model import load_policy, save_policy
from sim1.policy.training import JOINTS, TrainingPlan, chunks_of, open_loop_error, train
from sim1.stage import BadInput

PLAN = TrainingPlan(steps=1200, batch=64, learning_rate=2e-3, input_noise=0.0, chunk_frames=8, width=64, depth=2)
GARMENTS = ["towel", "tshirt"]


def test_a_chunk_holds_the_next_commands_and_keeps_the_last():
    action = np.arange(5.0)[:, None]
    assert chunks_of(action, 3)[:, :, 0].tolist() == [[0, 1, 2], [1, 2, 3], [2, 3, 4], [3, 4, 4], [4, 4, 4]]


def test_normalisation_is_undone_exactly_and_has_unit_spread(trajectories):
    policy = train(trajectories, GARMENTS, replace(PLAN, steps=1), seed=0)
    actions = torch.from_numpy(np.concatenate([item.action for item in trajectories]))
    normal = policy.normalise_action(actions)
    assert normal[:, JOINTS].std(0, correction=0).numpy() == pytest.approx(1, abs=1e-3)
    assert normal.mean(0).abs().max() < 1e-4
    assert (policy.restore_action(normal) - actions).abs().max() < 1e-6


def test_a_channel_that_never_moves_does_not_blow_up(trajectories):
    still = [replace(item, keypoints=item.keypoints * 0) for item in trajectories]
    policy = train(still, GARMENTS, PLAN, seed=0)
    moved = policy.predict(still[0].state, still[0].keypoints + 1e-4, still[0].garment)
    assert np.abs(moved).max() < 3


def test_policy_learns_its_own_demonstrations(trajectories):
    policy = train(trajectories, GARMENTS, PLAN, seed=0)
    for item in trajectories:
        error = open_loop_error(policy, item)
        assert error.joint_error_rad < 0.3 * error.hold_joint_error_rad


def test_same_seed_same_bytes_other_seed_other_bytes(tmp_path, trajectories):
    plan = replace(PLAN, steps=20, input_noise=0.05)
    digests = []
    for name, seed in (("a", 3), ("b", 3), ("c", 4)):
        save_policy(tmp_path / name, train(trajectories, GARMENTS, plan, seed))
        digests.append(hashlib.sha256((tmp_path / name).read_bytes()).hexdigest())
    assert digests[0] == digests[1] != digests[2]


def test_training_leaves_the_global_random_state_alone(trajectories):
    before = torch.random.get_rng_state()
    train(trajectories, GARMENTS, replace(PLAN, steps=2), seed=0)
    assert torch.equal(before, torch.random.get_rng_state())


def test_a_saved_policy_predicts_the_same_after_reading(tmp_path, trajectories):
    policy = train(trajectories, GARMENTS, replace(PLAN, steps=5), seed=0)
    save_policy(tmp_path / "p.safetensors", policy)
    again = load_policy(tmp_path / "p.safetensors")
    item = trajectories[0]
    assert again.shape == policy.shape
    np.testing.assert_array_equal(
        again.predict(item.state, item.keypoints, "towel"), policy.predict(item.state, item.keypoints, "towel")
    )


@pytest.mark.parametrize("damage", ["cut", "empty", "missing"])
def test_a_damaged_policy_file_is_named(tmp_path, trajectories, damage):
    path = tmp_path / "p.safetensors"
    save_policy(path, train(trajectories, GARMENTS, replace(PLAN, steps=1), seed=0))
    if damage == "missing":
        path.unlink()
    else:
        path.write_bytes(path.read_bytes()[: 500 if damage == "cut" else 0])
    with pytest.raises(BadInput, match=r"p\.safetensors.*train it again"):
        load_policy(path)
