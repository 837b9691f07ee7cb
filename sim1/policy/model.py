"""The state policy: a small network from joints and garment keypoints to a chunk of future commands."""

import json
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import torch
from safetensors import safe_open
from safetensors.torch import save_file
from torch import nn

from sim1.stage import BadInput
from sim1.whole_file import whole_file

SCHEMA = "sim1.policy/2"
MIN_SPREAD = 0.01  # rad, m or openness: a channel that hardly moves is not blown up by its normalisation
FAR_INPUT = 5.0  # spreads from the mean; what lies further out than training ever saw is taken to lie there


@dataclass(frozen=True, kw_only=True)
class PolicyShape:
    """Everything that is needed to build the network again."""

    garments: tuple[str, ...]
    state_size: int
    keypoint_size: int
    action_size: int
    chunk_frames: int  # commands predicted at once, at the dataset's rate
    width: int
    depth: int  # hidden layers

    @property
    def input_size(self) -> int:
        return self.state_size + self.keypoint_size


class ChunkPolicy(nn.Module):
    """MLP (b, input) -> (b, chunk_frames, action_size), in natural units; it carries its own normalisation."""

    def __init__(self, shape: PolicyShape) -> None:
        super().__init__()
        self.shape = shape
        sizes = [shape.input_size + len(shape.garments), *[shape.width] * shape.depth]
        layers: list[nn.Module] = []
        for size_in, size_out in pairwise(sizes):
            layers += [nn.Linear(size_in, size_out), nn.GELU()]
        self.body = nn.Sequential(*layers, nn.Linear(sizes[-1], shape.chunk_frames * shape.action_size))
        for name, size in (("input", shape.input_size), ("action", shape.action_size)):
            self.register_buffer(f"{name}_mean", torch.zeros(size))
            self.register_buffer(f"{name}_std", torch.ones(size))

    def set_normalisation(self, inputs: np.ndarray, actions: np.ndarray) -> None:
        """Take mean and spread from training data, (n, input) and (n, action)."""
        for name, values in (("input", inputs), ("action", actions)):
            getattr(self, f"{name}_mean").copy_(torch.from_numpy(values.mean(axis=0)))
            getattr(self, f"{name}_std").copy_(torch.from_numpy(values.std(axis=0).clip(MIN_SPREAD)))

    def forward(self, inputs: torch.Tensor, garment: torch.Tensor) -> torch.Tensor:
        """Normalised chunk (b, chunk_frames, action) from natural inputs (b, input) and a one-hot garment (b, g)."""
        normal = ((inputs - self.input_mean) / self.input_std).clamp(-FAR_INPUT, FAR_INPUT)
        flat = self.body(torch.cat([normal, garment], dim=-1))
        return flat.unflatten(-1, (self.shape.chunk_frames, self.shape.action_size))

    def is_finite(self) -> bool:
        """Whether weights and normalisation are numbers."""
        return all(bool(tensor.isfinite().all()) for tensor in self.state_dict().values())

    def normalise_action(self, action: torch.Tensor) -> torch.Tensor:
        return (action - self.action_mean) / self.action_std

    def restore_action(self, normal: torch.Tensor) -> torch.Tensor:
        return normal * self.action_std + self.action_mean

    @torch.no_grad()
    def predict(self, state: np.ndarray, keypoints: np.ndarray, garment: str) -> np.ndarray:
        """Commands (n, chunk_frames, action_size) for states (n, 14) and keypoints (n, 3 k)."""
        inputs = torch.from_numpy(np.concatenate([state, keypoints], axis=-1).astype(np.float32))
        one_hot = torch.zeros(len(inputs), len(self.shape.garments))
        one_hot[:, self.shape.garments.index(garment)] = 1
        return self.restore_action(self(inputs, one_hot)).numpy()


def save_policy(path: Path, policy: ChunkPolicy, learnt: str = "") -> None:
    """Weights, normalisation, shape and how it learnt in one safetensors file, there whole or not at all."""
    tensors = {name: tensor.contiguous() for name, tensor in sorted(policy.state_dict().items())}
    # One entry: safetensors writes several in an order that changes from process to process.
    about = json.dumps({"schema": SCHEMA, **asdict(policy.shape), "learnt": learnt}, sort_keys=True)
    with whole_file(path) as part:
        save_file(tensors, part, metadata={"policy": about})


def load_policy(path: Path) -> ChunkPolicy:
    """Read what `save_policy` wrote.

    Raises:
        BadInput: the file is missing, damaged or of another schema.
    """
    return _read(path)[0]


def kept_policy(path: Path, learnt: str) -> ChunkPolicy | None:
    """The policy in a file, if there is a whole one that learnt so."""
    try:
        policy, found = _read(path)
    except BadInput:
        return None
    return policy if found == learnt else None


def _read(path: Path) -> tuple[ChunkPolicy, str]:
    """A policy, and how it learnt."""
    try:
        with safe_open(path, framework="pt") as file:
            about = json.loads(file.metadata()["policy"])
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118, not a dict
        if about.pop("schema") != SCHEMA:
            raise BadInput(f"{path}: not a policy of schema {SCHEMA}; train it again")
        learnt = about.pop("learnt")
        policy = ChunkPolicy(PolicyShape(**{**about, "garments": tuple(about["garments"])}))
        policy.load_state_dict(tensors)
    except BadInput:
        raise
    except Exception as error:  # safetensors raises its own kinds, all for a damaged file
        raise BadInput(f"{path}: not a readable policy ({error}); train it again") from error
    return policy.eval(), learnt
