"""Training of the motion model on CPU: a few hundred small steps."""

import copy
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from sim1.motion.network import MotionTransformer, inner_mask, signal_and_noise
from sim1.motion.transitions import Bank, principal_shapes
from sim1.progress import track

EMA_DECAY = 0.99


@dataclass(frozen=True, kw_only=True)
class Trained:
    """A trained network with the record of its training."""

    network: MotionTransformer  # the moving average of the weights
    losses: list[float]  # per step, in units of the residual's variance
    trivial_loss: float  # of predicting the interpolant alone, on the training examples
    held_out_loss: float | None
    held_out_trivial: float | None  # of predicting the interpolant alone


def train(
    bank: Bank, held_out: Bank | None, scale: np.ndarray, *, width: int, layer_count: int, shape_count: int,
    step_count: int, batch_size: int, learning_rate: float, rng: np.random.Generator,
) -> Trained:  # fmt: skip
    """Minimise the squared error of the clean residual over random noise levels, one per token."""
    torch.manual_seed(int(rng.integers(2**31)))
    noise = torch.Generator().manual_seed(int(rng.integers(2**31)))
    data = tensors(bank, scale)
    shapes = principal_shapes(bank.residual, scale, shape_count)
    network = MotionTransformer(width, layer_count, bank.residual.shape[1], len(shapes))
    network.shapes.copy_(torch.as_tensor(shapes))
    average = copy.deepcopy(network)
    optimizer = torch.optim.AdamW(network.parameters(), lr=learning_rate, weight_decay=1e-4)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, learning_rate, total_steps=step_count, pct_start=0.1)
    losses = []
    for _ in track(range(step_count), "training the motion model"):
        rows = torch.randint(len(data[0]), (batch_size,), generator=noise)
        loss = denoising_loss(network, [part[rows] for part in data], noise)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        schedule.step()
        losses.append(loss.item())
        with torch.no_grad():
            decay = min(EMA_DECAY, len(losses) / (len(losses) + 10))
            for slow, fast in zip(average.parameters(), network.parameters(), strict=True):
                slow.lerp_(fast, 1 - decay)
    average.eval()
    loss = trivial = None
    if held_out is not None:
        other = tensors(held_out, scale)
        with torch.no_grad():
            loss = float(denoising_loss(average, other, noise))
        trivial = float((other[0][:, 1:-1] ** 2).mean())
    return Trained(
        network=average,
        losses=losses,
        trivial_loss=float((data[0][:, 1:-1] ** 2).mean()),
        held_out_loss=loss,
        held_out_trivial=trivial,
    )


def tensors(bank: Bank, scale: np.ndarray) -> list[Tensor]:
    """Residual in units of `scale`, interpolant, history, what comes after and steps as float32."""
    parts = (bank.residual / scale, bank.base, bank.history, bank.after, bank.steps)
    return [torch.as_tensor(part, dtype=torch.float32) for part in parts]


def denoising_loss(network: MotionTransformer, batch: list[Tensor], noise: torch.Generator) -> Tensor:
    """Mean squared error over inner tokens; half of the batch shares one noise level, half has one per token."""
    clean, *context = batch
    count, token_count = clean.shape[:2]
    level = torch.rand(count, token_count, generator=noise)
    shared = torch.arange(count) < count // 2
    level = torch.where(shared[:, None], level[:, :1], level) * inner_mask(token_count)[:, 0]
    signal, spread = signal_and_noise(level)
    noisy = signal[..., None] * clean + spread[..., None] * torch.randn(clean.shape, generator=noise)
    predicted = network(noisy, level, *context)
    return ((predicted - clean)[:, 1:-1] ** 2).mean()
