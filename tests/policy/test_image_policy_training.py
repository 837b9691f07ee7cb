"""Training on pictures: what it sees, what normalises it, and that a killed one ends like an undisturbed one."""

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from painted_world import HELD_OUT, POLICIES, Painter, write_world

from sim1.dataset.keypoints import KEYPOINTS
from sim1.policy.image.build import load, policy_config, processors, save
from sim1.policy.image.checkpoint import HALF
from sim1.policy.image.clips import split_clips
from sim1.policy.image.frames import KeptFrames, open_frames, read_features, seen_by, training_statistics
from sim1.policy.image.policy_file import PolicyFile
from sim1.policy.image.training import TrainingPlan, train
from sim1.progress import listening
from sim1.stage import BadInput

pytestmark = pytest.mark.filterwarnings("ignore")  # of torch and torchvision, not of this project
PLAN = TrainingPlan(steps=9, batch=16, seed=5)  # five batches are an epoch, the last one smaller
TINY = PolicyFile(
    title="ACT",
    type="act",
    settings={
        "pretrained_backbone_weights": None, "dim_model": 16, "n_heads": 2, "dim_feedforward": 16, "n_encoder_layers": 1,
        "n_vae_encoder_layers": 1, "latent_dim": 4, "optimizer_lr": 1e-3, "optimizer_lr_backbone": 1e-4,
    },
)  # fmt: skip


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sim1.render.blender.run_blender", Painter())
        return write_world(tmp_path_factory.mktemp("world"))["dataset"][""]


@pytest.fixture(scope="module")
def config(dataset):
    features = read_features(dataset)
    return policy_config(POLICIES / "act.yaml", TINY, "tiny", features=features, chunk_frames=4, device="cpu")


@pytest.fixture(scope="module")
def episodes(dataset) -> list[int]:
    return [clip.episode_index for clip in split_clips(dataset, 0.25, seed=0).train]


def fit(dataset, config, episodes, folder, plan=PLAN):
    statistics = training_statistics(dataset, episodes)
    return train(dataset, episodes, config, None, (), statistics, plan, folder / "training")


def digests(folder: Path, trained) -> dict[str, str]:
    save(folder / "policy", trained)
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted((folder / "policy").iterdir())}


def test_all_appearances_of_a_trajectory_are_on_one_side(dataset):
    parts = split_clips(dataset, 0.25, seed=0)
    assert {clip.trajectory.name for clip in parts.held_out} == {HELD_OUT}
    assert sorted(clip.appearance for clip in parts.held_out) == [0, 1]
    assert len(parts.train) == 8
    assert parts.splits["towel"].kind == "source"


def test_normalisation_knows_the_training_part_alone(dataset, config, episodes):
    parts = split_clips(dataset, 0.25, seed=0)
    states = np.concatenate([clip.trajectory.state for clip in parts.train])
    statistics = training_statistics(dataset, episodes)
    np.testing.assert_allclose(statistics["observation.state"]["mean"], states.mean(axis=0), atol=1e-6)
    np.testing.assert_allclose(statistics["observation.state"]["std"], states.std(axis=0), atol=1e-6)
    held_out = np.concatenate([clip.trajectory.state for clip in parts.held_out])
    assert np.abs(held_out.mean(axis=0) - states.mean(axis=0)).max() > 0.01

    prepare, restore = processors(config, statistics)
    batch = next(iter(torch.utils.data.DataLoader(open_frames(dataset, episodes, config), batch_size=8)))
    action = batch["action"].clone()
    ready = prepare(seen_by(config, batch))
    np.testing.assert_allclose(
        ready["observation.state"].numpy(),
        (states[:8] - states.mean(axis=0)) / (states.std(axis=0) + 1e-8),
        atol=1e-3,
    )
    np.testing.assert_allclose(restore(ready["action"]).numpy(), action.numpy(), atol=1e-5)


def test_privileged_columns_never_reach_the_policy(dataset, config, episodes):
    batch = open_frames(dataset, episodes, config)[0]
    assert KEYPOINTS in batch
    assert set(seen_by(config, batch)) == {
        "observation.images.head", "observation.state", "action", "action_is_pad", "task",
    }  # fmt: skip


@pytest.mark.parametrize("room_frames", [0, 3, 1000])
def test_frames_that_are_kept_are_those_that_were_read(dataset, config, episodes, room_frames, monkeypatch):
    frames = open_frames(dataset, episodes, config)
    size = sum(value.nbytes for value in frames[0].values() if isinstance(value, torch.Tensor))
    size -= 3 * frames[0]["observation.images.head"].numel()  # four bytes of a number become one
    kept = KeptFrames(frames, room_frames * size)
    plain, reads = [frames[index] for index in range(6)], []
    read = type(frames).__getitem__
    monkeypatch.setattr(type(frames), "__getitem__", lambda self, index: (reads.append(index), read(self, index))[1])
    for _ in range(2):
        for index, expected in enumerate(plain):
            found = kept[index]
            assert found.keys() == expected.keys()
            for name, value in expected.items():
                assert found[name].equal(value) if isinstance(value, torch.Tensor) else found[name] == value
    assert reads == [*range(6), *range(room_frames, 6)]


def test_a_policy_is_the_same_whether_frames_are_kept_or_read_again(tmp_path, dataset, config, episodes):
    several = replace(PLAN, steps=12)  # more frames than there are: some come a second time
    found = [
        digests(
            tmp_path / str(mib), fit(dataset, config, episodes, tmp_path / str(mib), replace(several, kept_mib=mib))[0]
        )
        for mib in (0, 64)
    ]
    assert found[0] == found[1]


def test_the_loss_falls_and_the_saved_policy_is_the_trained_one(tmp_path, dataset, config, episodes):
    trained, losses = fit(dataset, config, episodes, tmp_path, replace(PLAN, steps=30))
    assert np.mean(losses[-5:]) < 0.6 * np.mean(losses[:5])
    save(tmp_path / "policy", trained)
    again = load(tmp_path / "policy", "cpu")
    batch = next(iter(torch.utils.data.DataLoader(open_frames(dataset, episodes, config), batch_size=4)))
    said = [
        item.restore(item.policy.predict_action_chunk(item.prepare(seen_by(config, batch))))
        for item in (trained, again)
    ]
    assert said[0].shape == (4, 4, 14)
    assert torch.equal(*said)


def test_same_seed_same_bytes_other_seed_other_bytes_and_no_trace_in_the_random_state(
    tmp_path, dataset, config, episodes
):
    before = torch.random.get_rng_state()
    found = []
    for name, seed in (("a", 5), ("b", 5), ("c", 6)):
        found.append(
            digests(tmp_path / name, fit(dataset, config, episodes, tmp_path / name, replace(PLAN, seed=seed))[0])
        )
    assert found[0] == found[1]
    assert found[0]["model.safetensors"] != found[2]["model.safetensors"]
    assert torch.equal(before, torch.random.get_rng_state())


def test_a_dataset_whose_description_is_damaged_is_named(tmp_path):
    (tmp_path / "lerobot" / "meta").mkdir(parents=True)
    (tmp_path / "lerobot" / "meta" / "info.json").write_text("{")
    with pytest.raises(BadInput, match=r"lerobot/meta: not readable .* make the dataset again"):
        read_features(tmp_path)


def test_statistics_that_the_dataset_does_not_have_are_not_made_up(dataset):
    with pytest.raises(BadInput, match="statistics of 1 of 2 episodes; make the dataset again"):
        training_statistics(dataset, [0, 999])


class Killed(Exception):
    pass


def kill_at(step: int, dataset, config, episodes, folder, plan) -> None:
    def sink(done, total, what):
        if done == step:
            raise Killed

    with listening(sink), pytest.raises(Killed):
        fit(dataset, config, episodes, folder, plan)


@pytest.mark.parametrize(
    "steps",
    [pytest.param((5,), marks=pytest.mark.slow, id="between epochs"), pytest.param((2, 7), id="twice, in epochs")],
)
def test_a_killed_and_resumed_training_ends_with_the_bytes_of_an_undisturbed_one(
    tmp_path, dataset, config, episodes, steps
):
    whole, losses = fit(dataset, config, episodes, tmp_path / "whole")
    often = replace(PLAN, checkpoint_s=0.0)
    for step in steps:
        kill_at(step, dataset, config, episodes, tmp_path / "killed", often)
        assert [path.name for path in (tmp_path / "killed" / "training").iterdir()] == [f"{step:08d}"]
        (tmp_path / "killed" / "training" / HALF).mkdir()  # killed while it wrote the next one
    resumed, again = fit(dataset, config, episodes, tmp_path / "killed", often)
    assert again == losses
    assert digests(tmp_path / "killed", resumed) == digests(tmp_path / "whole", whole)


@pytest.mark.slow
def test_who_decodes_the_videos_changes_no_byte(tmp_path, dataset, config, episodes):
    """Over more than an epoch: worker processes are kept, and read ahead. That saving changes none is seen where one is killed."""
    plain, losses = fit(dataset, config, episodes, tmp_path / "plain")
    other, again = fit(dataset, config, episodes, tmp_path / "other", replace(PLAN, workers=2))
    assert again == losses
    assert digests(tmp_path / "other", other) == digests(tmp_path / "plain", plain)


def test_a_damaged_checkpoint_is_named(tmp_path, dataset, config, episodes):
    often = replace(PLAN, checkpoint_s=0.0)
    kill_at(3, dataset, config, episodes, tmp_path, often)
    (tmp_path / "training" / "00000003" / "model.safetensors").write_bytes(b"half")
    with pytest.raises(BadInput, match=r"00000003: the interrupted training cannot go on .*sim1 clean"):
        fit(dataset, config, episodes, tmp_path, often)


@pytest.mark.parametrize("damage", ["cut", "missing", "config"])
def test_a_damaged_policy_is_named(tmp_path, dataset, config, episodes, damage):
    trained, _ = fit(dataset, config, episodes, tmp_path, replace(PLAN, steps=1))
    save(tmp_path / "policy", trained)
    path = tmp_path / "policy" / ("config.json" if damage == "config" else "model.safetensors")
    if damage == "missing":
        path.unlink()
    else:
        path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(BadInput, match=r"lerobot cannot load the policy .* make image_policy again"):
        load(tmp_path / "policy", "cpu")
