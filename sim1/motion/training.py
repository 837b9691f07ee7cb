"""Training of the motion model on CPU: a few hundred small steps."""

import copy
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor
from torch.nn import Module

from sim1.motion.network import MotionTransformer, inner_mask, signal_and_noise
from sim1.motion.transitions import Bank, principal_shapes
from sim1.progress import track

EMA_DECAY = 0.99
PROBE_COUNT = 128  # examples on which the trained network is measured


@dataclass(frozen=True, kw_only=True)
class Trained:
    """A trained network with the record of its training."""

    network: MotionTransformer  # the moving average of the weights
    losses: list[float]  # per step, in units of the residual's variance
    trivial_loss: float  # of predicting the interpolant alone, on the training examples
    held_out_loss: float | None
    held_out_trivial: float | None  # of predicting the interpolant alone
    from_noise_loss: float  # of examples in which nothing is left but noise, held-out ones where there are any
    from_noise_trivial: float  # of the interpolant, or of the mean residual of the training, whichever is better


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
    other = None if held_out is None else tensors(held_out, scale)
    probe = other or [part[:PROBE_COUNT] for part in data]
    with torch.no_grad():
        return Trained(
            network=average,
            losses=losses,
            trivial_loss=float(squared_error(torch.zeros_like(data[0]), data[0])),
            held_out_loss=None if other is None else float(denoising_loss(average, other, noise)),
            held_out_trivial=None if other is None else float(squared_error(torch.zeros_like(other[0]), other[0])),
            from_noise_loss=float(loss_from_noise(average, probe, noise)),
            from_noise_trivial=trivial_from_noise(data[0], probe[0]),
        )


def tensors(bank: Bank, scale: np.ndarray) -> list[Tensor]:
    """Residual in units of `scale`, interpolant, history, what comes after and steps as float32."""
    parts = (bank.residual / scale, bank.base, bank.history, bank.after, bank.steps)
    return [torch.as_tensor(part, dtype=torch.float32) for part in parts]


def denoising_loss(network: Module, batch: list[Tensor], noise: torch.Generator) -> Tensor:
    """Mean squared error over inner tokens; half of the batch shares one noise level, half has one per token."""
    count, token_count = batch[0].shape[:2]
    level = torch.rand(count, token_count, generator=noise)
    shared = torch.arange(count) < count // 2
    return _loss_at(network, batch, torch.where(shared[:, None], level[:, :1], level), noise)


def loss_from_noise(network: Module, batch: list[Tensor], noise: torch.Generator) -> Tensor:
    """The same error where the network is given nothing but noise between the boundary tokens.

    At lower levels a network that only shrinks what it is given has a small error; here none has that knows nothing of the data.
    """
    return _loss_at(network, batch, torch.ones(batch[0].shape[:2]), noise)


def trivial_from_noise(known: Tensor, clean: Tensor) -> float:
    """Error in `clean` (b, n, 20) of the better one of two predictions without a network: zero, and the mean of `known`."""
    mean = known.mean(dim=0).expand_as(clean)
    return min(float(squared_error(torch.zeros_like(clean), clean)), float(squared_error(mean, clean)))


def squared_error(predicted: Tensor, clean: Tensor) -> Tensor:
    """Mean over inner tokens of (b, n, 20)."""
    return ((predicted - clean)[:, 1:-1] ** 2).mean()


def _loss_at(network: Module, batch: list[Tensor], level: Tensor, noise: torch.Generator) -> Tensor:
    clean, *context = batch
    level = level * inner_mask(clean.shape[1])[:, 0]
    signal, spread = signal_and_noise(level)
    noisy = signal[..., None] * clean + spread[..., None] * torch.randn(clean.shape, generator=noise)
    return squared_error(network(noisy, level, *context), clean)
