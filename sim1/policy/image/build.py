"""Policies of lerobot's, made from a policy file, saved and loaded in lerobot's own format."""

import contextlib
import dataclasses
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import draccus
import numpy as np
import safetensors
import torch
from lerobot.configs import FeatureType, PolicyFeature, PreTrainedConfig
from lerobot.policies.factory import get_policy_class, make_pre_post_processors
from lerobot.policies.pretrained import PreTrainedPolicy
from lerobot.processor import PolicyProcessorPipeline

from sim1.policy.episodes import ACTION, STATE
from sim1.policy.image.frames import Batch, Statistics
from sim1.policy.image.policy_file import PolicyFile, Size
from sim1.stage import BadInput

TAKEN_UP = 0.5  # share of the published tensors that must be found in the policy: lerobot renames some
PROBED = 256  # numbers of a tensor by which it is known again, whatever it is called
_OTHERS = "these are weights of another policy, or the settings in the policy file do not fit them"


@dataclass(frozen=True, kw_only=True)
class Trained:
    """A policy with what stands before and behind it."""

    policy: PreTrainedPolicy
    prepare: PolicyProcessorPipeline  # batch of the dataset -> normalised batch on the policy's device
    restore: PolicyProcessorPipeline  # the policy's answer -> commands in rad and openness, on the CPU

    @torch.no_grad()
    def answer(self, seen: Batch) -> np.ndarray:
        """Chunks of commands (b, chunk, 14) to a batch of what the policy may see; it remembers nothing of the one before."""
        self.policy.reset()
        return self.restore(self.policy.predict_action_chunk(self.prepare(seen))).float().numpy()


def policy_config(
    path: Path, file: PolicyFile, size: Size, *, features: Mapping[str, PolicyFeature], chunk_frames: int, device: str
) -> PreTrainedConfig:
    """Lerobot's configuration of a policy that sees cameras and joint state, and nothing privileged.

    Args:
        path: of the policy file, for messages.
        file: its contents.
        size: which of its sizes.
        features: of the dataset, by name.
        chunk_frames: commands that the policy predicts at once; more, where its architecture cannot do so few.
        device: torch's name.

    Raises:
        BadInput: lerobot has no such policy or no such setting, or a value is none that it takes.
    """
    try:
        kind = PreTrainedConfig.get_choice_class(file.type)
    except KeyError:
        known = ", ".join(sorted(PreTrainedConfig.get_known_choices()))
        raise BadInput(f"{path}: type is {file.type!r}, which lerobot does not know; it has {known}") from None
    settings = {**file.at(size), "device": device, "push_to_hub": False}
    try:
        settings |= _chunk(path, kind, settings, chunk_frames)
        config = draccus.decode(kind, settings)
        config.input_features = {
            name: item for name, item in features.items() if item.type is FeatureType.VISUAL or name == STATE
        }
        config.output_features = {ACTION: features[ACTION]}
        config.validate_features()
    except (draccus.utils.DraccusException, TypeError, ValueError, NotImplementedError) as error:
        said = f"{error} {error.__cause__ or ''}".strip()
        raise BadInput(f"{path}: settings of a {file.type} policy at size {size}: {said}; correct the file") from error
    return config


def new_policy(config: PreTrainedConfig, weights: Path | None, fresh: Sequence[str] = ()) -> PreTrainedPolicy:
    """A policy with random weights (from torch's random state), or with published ones.

    Args:
        config: of the policy.
        weights: folder of published ones.
        fresh: beginnings of names of parameters that these do not have, and that may begin at random beside them.

    Raises:
        BadInput: lerobot did not take up the published weights, or they lack parameters; some of its policies only print so and go on.
    """
    kind = get_policy_class(config.type)
    with _silence():
        if weights is None:
            return kind(config).to(config.device)
        try:
            policy = kind.from_pretrained(weights, config=config, local_files_only=True)
        except (OSError, ValueError, RuntimeError, safetensors.SafetensorError) as error:
            raise BadInput(
                f"{weights}: lerobot cannot make a {config.type} policy of it ({error}); {_OTHERS}"
            ) from error
    if (share := _share_taken_up(policy, weights / "model.safetensors")) < TAKEN_UP:
        raise BadInput(
            f"{weights}/model.safetensors: {100 * share:.0f} % of its tensors are in the {config.type} policy that lerobot "
            f"made of it, at least {100 * TAKEN_UP:.0f} % are expected; {_OTHERS}"
        )
    if lacking := [
        name for name in _untouched(policy, weights / "model.safetensors") if not name.startswith(tuple(fresh))
    ]:
        some = ", ".join(lacking[:3]) + (f" and {len(lacking) - 3} others" if len(lacking) > 3 else "")
        raise BadInput(
            f"{weights}/model.safetensors: {len(lacking)} parameters of the {config.type} policy are not in it and would begin at random "
            f"({some}); take weights of the whole policy, or name them under needs.weights.fresh of the policy file"
        )
    return policy.to(config.device)


def processors(
    config: PreTrainedConfig, statistics: Statistics
) -> tuple[PolicyProcessorPipeline, PolicyProcessorPipeline]:
    """What normalises a batch and what undoes it for commands, with the statistics of the training data."""
    own = {name: dict(statistics[name]) for name in (*config.input_features, *config.output_features)}
    return make_pre_post_processors(config, dataset_stats=own)


def save(folder: Path, trained: Trained) -> None:
    """Write what lerobot's `from_pretrained` reads: configuration, weights, both processors."""
    trained.policy.save_pretrained(folder)
    trained.prepare.save_pretrained(folder)
    trained.restore.save_pretrained(folder)


def trained_on(folder: Path) -> str:
    """Torch's name of the device on which the policy that `save` wrote was trained; what this machine has is no matter.

    Raises:
        BadInput: the configuration is missing or damaged.
    """
    path = folder / "config.json"
    try:
        return str(json.loads(path.read_text())["device"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"{path}: does not say on what it was trained ({error}); make image_policy again") from error


def load(folder: Path, device: str) -> Trained:
    """Read what `save` wrote, with lerobot's own loaders.

    Raises:
        BadInput: a file is missing or damaged.
    """
    try:
        config = PreTrainedConfig.from_pretrained(folder)
        config.device = device
        with _silence():
            policy = get_policy_class(config.type).from_pretrained(folder, config=config, strict=True)
        on_device = {"device_processor": {"device": device}}
        prepare, restore = make_pre_post_processors(
            config, pretrained_path=str(folder), preprocessor_overrides=on_device
        )
        if _share_taken_up(policy, folder / "model.safetensors") < 1:
            raise ValueError("not all of model.safetensors is in what it made")
    except (OSError, ValueError, KeyError, RuntimeError, safetensors.SafetensorError) as error:
        raise BadInput(f"{folder}: lerobot cannot load the policy ({error}); make image_policy again") from error
    return Trained(policy=policy, prepare=prepare, restore=restore)


def _chunk(path: Path, kind: type, settings: Mapping[str, Any], frames: int) -> dict[str, int]:
    """Settings that make a policy predict at least `frames` commands from the current frame on."""
    fields = {item.name: item for item in dataclasses.fields(kind)}
    if "chunk_size" in fields:
        return {"chunk_size": frames, "n_action_steps": frames}
    if "horizon" in fields and "down_dims" in fields:
        # A diffusion policy's chunk begins with its oldest observation, and is halved at every level of its U-net.
        past = settings.get("n_obs_steps", fields["n_obs_steps"].default) - 1
        block = 2 ** len(settings.get("down_dims", fields["down_dims"].default))
        horizon = -(-(past + frames) // block) * block
        return {"horizon": horizon, "n_action_steps": frames, "drop_n_last_frames": 0}
    raise BadInput(
        f"{path}: type is {kind.get_choice_name(kind)!r}, which predicts no chunks of commands; choose another"
    )


def _share_taken_up(policy: PreTrainedPolicy, path: Path) -> float:
    own = policy.state_dict()
    with safetensors.safe_open(path, framework="pt") as file:
        names = list(file.keys())
        found = 0
        for name in names:
            mine = own.get(name, own.get(f"model.{name}"))
            theirs = file.get_tensor(name)
            found += mine is not None and mine.shape == theirs.shape and _alike(mine.cpu(), theirs.to(mine.dtype))
    return found / max(len(names), 1)


def _untouched(policy: PreTrainedPolicy, path: Path) -> list[str]:
    """Names of the policy's parameters that are in no tensor of the file, whatever that calls them."""
    with safetensors.safe_open(path, framework="pt") as file:
        known = {_probe(file.get_tensor(name)) for name in file.keys()}  # noqa: SIM118, not a dict
    return [name for name, item in policy.named_parameters() if _probe(item) not in known]


def _probe(tensor: torch.Tensor) -> tuple[torch.Size, bytes]:
    """Shape and some numbers of a tensor, as coarse as the coarsest type in which weights are published or loaded."""
    flat = tensor.detach().cpu().flatten()
    some = flat[:: max(1, flat.numel() // PROBED)].to(torch.bfloat16)
    return tensor.shape, some.view(torch.int16).numpy().tobytes()


def _alike(mine: torch.Tensor, theirs: torch.Tensor) -> bool:
    """The same numbers in the same places; what is no number in both counts as the same."""
    return torch.equal(mine.nan_to_num(), theirs.nan_to_num())


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Lerobot prints while it loads; stages do not."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield
