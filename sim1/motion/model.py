"""The trained motion model as files, and transitions drawn from it."""

from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import torch

from sim1.motion.durations import DurationModel
from sim1.motion.interpolant import ENDS, interpolate, straight
from sim1.motion.network import MotionTransformer, inner_mask, signal_and_noise
from sim1.motion.poses import ToolPath, joined, to_tokens, turned_tokens
from sim1.motion.residual import assemble
from sim1.motion.transitions import outlook
from sim1.network_file import load_weights, read_network, write_network

SCHEMA = "sim1.motion-model/3"


@dataclass(frozen=True, kw_only=True)
class MotionModel:
    """How transitions are made; `network` is None where the method needs none."""

    method: str  # diffusion, minimum_jerk, straight or slicing
    durations: DurationModel
    network: MotionTransformer | None
    scale: np.ndarray  # (token_count, 20) size of the residual
    width: int
    layer_count: int
    token_count: int
    shape_count: int
    sampling_steps: int


def sample_residual(
    model: MotionModel, base: np.ndarray, history: np.ndarray, after: np.ndarray, steps: int, rng: np.random.Generator
) -> np.ndarray:
    """Residual (token_count, 20) by deterministic DDIM from random noise.

    Args:
        model: with a network.
        base: (token_count, 20) interpolant.
        history: (HISTORY_COUNT, 20)
        after: (ENDS, 20)
        steps: duration in frame steps.
        rng: gives the noise.
    """
    assert model.network is not None
    context = [torch.as_tensor(part, dtype=torch.float32)[None] for part in (base, history, after)]
    length = torch.tensor([float(steps)])
    inner = inner_mask(model.token_count)
    state = torch.as_tensor(rng.standard_normal((1, *base.shape)), dtype=torch.float32) * inner
    levels = np.linspace(1, 0, model.sampling_steps + 1)
    with torch.no_grad():
        for now, then in pairwise(levels.tolist()):
            level = torch.full((1, model.token_count), float(now)) * inner[:, 0]
            clean = model.network(state, level, *context, length)
            signal, spread = signal_and_noise(torch.tensor(float(now)))
            next_signal, next_spread = signal_and_noise(torch.tensor(float(then)))
            direction = (state - signal * clean) / spread
            state = (next_signal * clean + next_spread * direction) * inner
    # What the sampler adds beside the shapes that demonstrations take is noise.
    shapes = model.network.shapes.double().numpy()
    sampled = state[0].double().numpy()
    sampled = (shapes.T @ (shapes @ sampled.ravel())).reshape(sampled.shape)
    return sampled * inner.numpy() * model.scale


def transition(
    model: MotionModel, history: ToolPath, after: ToolPath, steps: int, rng: np.random.Generator
) -> ToolPath:
    """Frames from the last pose of `history` to the first of `after`, both included and exact: steps + 1 of them.

    Args:
        model: of any method but `slicing`.
        history: (HISTORY_COUNT) frames, the last one is the start pose.
        after: (ENDS) frames that follow, the first one is the end pose.
        steps: duration in frame steps, from `model.durations`.
        rng: gives the noise.
    """
    before = history[-ENDS:]
    if model.method == "straight":
        return straight(history[-1:], after[:1], steps)
    if model.method == "minimum_jerk":
        return interpolate(before, after, np.linspace(0, 1, steps + 1), steps)
    frame = outlook(history[-1:], after[:1])
    back = np.linalg.inv(frame)
    base = interpolate(before, after, np.linspace(0, 1, model.token_count), steps)
    residual = sample_residual(model, *(to_tokens(part.moved(back)) for part in (base, history, after)), steps, rng)
    return assemble(before, after, turned_tokens(residual, frame[:3, :3]), steps + 1)


def sliced(source: ToolPath, placement: np.ndarray, start: ToolPath, bridge_steps: int) -> ToolPath:
    """The source's own transition moved with the garment, reached on a straight line as in MimicGen.

    Args:
        source: the demonstrated transition before the next interaction.
        placement: (4, 4) motion of the garment since that demonstration.
        start: one frame, where the tools are.
        bridge_steps: frame steps of the straight line.
    """
    moved = source.moved(placement)
    return joined(straight(start, moved[:1], bridge_steps), moved[1:])


def write_model(folder: Path, model: MotionModel) -> None:
    """Write `model.json`, and `model.safetensors` (empty without a network)."""
    about = {
        "schema": SCHEMA, "method": model.method, "durations": asdict(model.durations), "scale": model.scale.tolist(),
        **{name: getattr(model, name) for name in _SIZES},
    }  # fmt: skip
    write_network(folder, model.network, about)


def _durations(about: dict[str, Any]) -> DurationModel:
    return DurationModel(**about | {"examples": tuple(tuple(row) for row in about["examples"])})


_SIZES = ("width", "layer_count", "token_count", "shape_count", "sampling_steps")


def read_model(folder: Path) -> MotionModel:
    """Read what `write_model` wrote.

    Raises:
        BadInput: a file is missing, damaged, or of another schema.
    """

    def build(about: dict[str, Any], weights: Path) -> MotionModel:
        network = None
        if about["method"] == "diffusion":
            network = load_weights(
                MotionTransformer(about["width"], about["layer_count"], about["token_count"], about["shape_count"]),
                weights,
            )
        return MotionModel(
            method=about["method"], durations=_durations(about["durations"]), network=network,
            scale=np.array(about["scale"]), **{name: about[name] for name in _SIZES},
        )  # fmt: skip

    return read_network(folder, SCHEMA, "motion_model", build)
