"""Policies as data: what a file may say, and what is said where the machine lacks what it needs."""

import pytest
import torch
import yaml
from lerobot.configs import FeatureType, PolicyFeature
from painted_world import POLICIES

import sim1.policy.image.needs as needs
from sim1.policy.image.build import new_policy, policy_config
from sim1.policy.image.frames import looks_back
from sim1.policy.image.policy_file import SCHEMA, find_policy
from sim1.policy.image.stage import check_source_policies
from sim1.stage import BadInput

FEATURES = {
    "observation.state": PolicyFeature(type=FeatureType.STATE, shape=(14,)),
    "observation.environment_state": PolicyFeature(type=FeatureType.ENV, shape=(36,)),  # of somebody else's dataset
    "observation.images.head": PolicyFeature(type=FeatureType.VISUAL, shape=(3, 24, 32)),
    "action": PolicyFeature(type=FeatureType.ACTION, shape=(14,)),
}
ACT = {"schema": SCHEMA, "title": "ACT", "type": "act", "settings": {"pretrained_backbone_weights": None}}


@pytest.fixture
def write(tmp_path):
    """Write a policy file; returns what `find_policy` makes of it."""

    def write(**changes):
        (tmp_path / "mine.yaml").write_text(yaml.safe_dump({**ACT, **changes}))
        return find_policy(tmp_path, "mine")

    return write


def config_of(path, file, size="tiny", chunk_frames=5):
    return policy_config(path, file, size, features=FEATURES, chunk_frames=chunk_frames, device="cpu")


@pytest.mark.parametrize("name", sorted(path.stem for path in POLICIES.glob("*.yaml")))
@pytest.mark.parametrize("size", ["tiny", "small", "full"])
def test_lerobot_takes_every_shipped_policy_at_every_size_and_it_sees_no_keypoints(name, size):
    config = config_of(*find_policy(POLICIES, name), size)
    assert set(config.input_features) == {"observation.state", "observation.images.head"}
    assert set(range(5)) <= set(config.action_delta_indices)  # at least the chunk that was asked for


@pytest.mark.parametrize(("name", "past"), [("act", False), ("diffusion", True)])
def test_which_policies_look_back(name, past):
    assert looks_back(config_of(*find_policy(POLICIES, name))) is past


def test_the_shipped_files_are_checked_before_any_work(tmp_path):
    check_source_policies(POLICIES)
    (tmp_path / "bad.yaml").write_text("schema: sim1.image_policy/1\ntitle: x\n")
    with pytest.raises(BadInput, match=r"bad\.yaml: key 'type' is missing"):
        check_source_policies(tmp_path)


def test_a_policy_that_is_not_there_is_answered_with_those_that_are(write):
    path, _ = write()
    with pytest.raises(BadInput, match=r"no policy 'pi6'; there are mine \(setting `policy`"):
        find_policy(path.parent, "pi6")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"setings": {}}, "unknown key 'setings'"),
        ({"needs": {"gpu": 8}}, r"unknown key 'needs\.gpu'"),
        ({"sizes": {"huge": {}}}, "sizes.huge"),
        (
            {"settings": {"chunk_size": 50}},
            r"settings\.chunk_size is 50: it comes from chunk_s of the stage; remove it",
        ),
        ({"sizes": {"full": {"device": "cuda"}}}, r"sizes\.full\.device is 'cuda': it comes from device of the stage"),
    ],
)
def test_a_fault_in_a_file_is_named_with_file_and_key(write, changes, said):
    with pytest.raises(BadInput, match=rf"mine\.yaml: .*{said}"):
        write(**changes)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"type": "actt"}, "type is 'actt', which lerobot does not know; it has act, diffusion"),
        ({"type": "gaussian_actor", "settings": {}}, "predicts no chunks of commands"),
        ({"settings": {"dim_modle": 64}}, "`dim_modle` are not valid for ACTConfig; correct the file"),
        ({"settings": {"dim_model": "wide"}}, "'wide'"),
        ({"type": "diffusion", "settings": {"n_obs_steps": "two"}}, "settings of a diffusion policy"),
        ({"type": "diffusion", "settings": {"down_dims": 64}}, "settings of a diffusion policy"),
        ({"settings": {"vision_backbone": "vgg"}}, "must be one of the ResNet variants"),
    ],
)
def test_what_lerobot_does_not_take_is_named_with_the_file(write, changes, said):
    path, file = write(**changes)
    with pytest.raises(BadInput, match=r"mine\.yaml: ") as error:
        config_of(path, file)
    assert said in str(error.value)


def test_all_that_a_machine_lacks_is_told_at_once_with_remedies(write, monkeypatch):
    monkeypatch.setattr(needs, "gpu_memory_gib", lambda: 0.0)
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    path, file = write(
        needs={
            "packages": ["no_such_package"],
            "extra": "pi",
            "weights": {"folder": "../weights/base", "source": "someone/base"},
            "hub": ["someone/tokenizer"],
            "gpu_gib": 24,
        }
    )
    with pytest.raises(BadInput) as error:
        needs.choose_device(path, file, "auto")
    said = str(error.value)
    folder = (path.parent / "../weights/base").resolve()
    for words in (
        "policy 'mine' cannot be trained here",
        "package no_such_package (uv pip install --python .venv/bin/python 'lerobot[pi]==",
        f"weights in {folder} (no config.json; with a network: hf download someone/base --local-dir {folder})",
        "someone/tokenizer in the hub's cache (with a network: hf download someone/tokenizer)",
        "a GPU with 24 GiB (torch finds none",
        "setting `policy` of stage image_policy, such as act",
    ):
        assert words in said


@pytest.mark.parametrize(
    ("needed_gib", "wanted", "has_gib", "said"),
    [
        (0, "gpu", 0, "a GPU (torch finds none; run on a machine that has one, or set `device` to auto)"),
        (24, "auto", 12, "a GPU with 24 GiB (this one has 12 GiB"),
        (24, "cpu", 80, "the setting `device` is cpu"),
    ],
)
def test_a_gpu_that_is_not_there_is_never_replaced_by_the_cpu(write, monkeypatch, needed_gib, wanted, has_gib, said):
    monkeypatch.setattr(needs, "gpu_memory_gib", lambda: has_gib)
    path, file = write(needs={"gpu_gib": needed_gib})
    with pytest.raises(BadInput) as error:
        needs.choose_device(path, file, wanted)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("needed_gib", "wanted", "has_gib", "device"),
    [
        (0, "auto", 0, "cpu"),
        (0, "auto", 12, "cuda"),
        (0, "cpu", 12, "cpu"),
        (0, "gpu", 12, "cuda"),
        (24, "auto", 80, "cuda"),
    ],
)
def test_the_device_is_the_one_that_was_asked_for(write, monkeypatch, needed_gib, wanted, has_gib, device):
    monkeypatch.setattr(needs, "gpu_memory_gib", lambda: has_gib)
    path, file = write(needs={"gpu_gib": needed_gib})
    assert needs.choose_device(path, file, wanted) == device


def test_training_starts_from_weights_that_a_file_names_and_from_no_others(write, tmp_path):
    path, file = write(
        needs={"weights": {"folder": "base", "source": "someone/base"}},
        settings={"pretrained_backbone_weights": None, "dim_model": 32, "n_heads": 2, "dim_feedforward": 32},
    )
    base = tmp_path / "base"
    torch.manual_seed(1)
    published = new_policy(config_of(path, file), None)
    published.save_pretrained(base)
    assert needs.choose_device(path, file, "cpu") == "cpu"

    torch.manual_seed(2)
    started = new_policy(config_of(path, file), needs.weights_folder(path, file.needs.weights))
    for name, tensor in published.state_dict().items():
        assert torch.equal(started.state_dict()[name], tensor), name

    wider = write(settings={"pretrained_backbone_weights": None, "dim_model": 64, "n_heads": 2})
    with pytest.raises(BadInput, match="base: lerobot cannot make a act policy of it"):
        new_policy(config_of(*wider), base)

    from safetensors.torch import save_file

    save_file({"something.else": torch.zeros(3)}, base / "model.safetensors")
    with pytest.raises(BadInput, match="0 % of its tensors are in the act policy"):
        new_policy(config_of(path, file), base)

    part = {name: value for name, value in published.state_dict().items() if name.startswith("model.backbone")}
    save_file(part, base / "model.safetensors")
    with pytest.raises(
        BadInput, match=r"parameters of the act policy are not in it and would begin at random \(model\."
    ):
        new_policy(config_of(path, file), base)
    assert new_policy(config_of(path, file), base, fresh=["model."]).config.type == "act"

    (base / "model.safetensors").write_bytes(b"half")
    with pytest.raises(BadInput, match=r"weights in .*base \(.*hf download someone/base"):
        needs.choose_device(path, file, "cpu")
