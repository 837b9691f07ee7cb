"""The transformer of the diffusion-forcing motion model.

Every token of a transition carries its own noise level, so that clean context and noisy future live in one sequence
(Chen et al. 2024; paper, section DataGen, equation of the denoising loss).
"""

import math

import torch
from torch import Tensor, nn

from sim1.episode import RATE_HZ
from sim1.motion.interpolant import ENDS
from sim1.motion.poses import TOKEN_SIZE
from sim1.motion.transitions import HISTORY_COUNT

POSITION_UNIT_M = 0.2  # brings positions to the size of the other channels


class MotionTransformer(nn.Module):
    """Predicts the clean residual of every token from noisy ones."""

    def __init__(self, width: int, layer_count: int, token_count: int, shape_count: int, head_count: int = 4) -> None:
        super().__init__()
        self.noise_embedding = nn.Sequential(nn.Linear(16, width), nn.SiLU(), nn.Linear(width, width))
        self.token_in = nn.Linear(2 * TOKEN_SIZE, width)
        self.neighbour_in = nn.Linear(TOKEN_SIZE, width)
        self.length_in = nn.Linear(1, width)
        self.place = nn.Parameter(0.02 * torch.randn(HISTORY_COUNT + token_count + ENDS, width))
        layer = nn.TransformerEncoderLayer(
            width, head_count, 2 * width, dropout=0.0, activation="gelu", batch_first=True, norm_first=True
        )
        self.encoder = nn.TransformerEncoder(layer, layer_count, enable_nested_tensor=False)
        self.norm = nn.LayerNorm(width)
        self.out = nn.Linear(width, TOKEN_SIZE)
        self.shapes: Tensor
        self.register_buffer("shapes", torch.zeros(shape_count, token_count * TOKEN_SIZE))  # of the training residuals
        nn.init.zeros_(self.out.weight)  # training starts from the interpolant itself
        nn.init.zeros_(self.out.bias)

    def forward(
        self, noisy: Tensor, level: Tensor, base: Tensor, history: Tensor, after: Tensor, steps: Tensor
    ) -> Tensor:
        """Clean residual, zero at both boundary tokens.

        Args:
            noisy: (b, n, 20) scaled residual with noise.
            level: (b, n) noise level in [0, 1] of every token.
            base: (b, n, 20) interpolant.
            history: (b, HISTORY_COUNT, 20)
            after: (b, ENDS, 20)
            steps: (b,) duration in frame steps.
        """
        unit = _units(base)
        tokens = self.token_in(torch.cat([noisy, base / unit], dim=-1)) + self.noise_embedding(_waves(level))
        # Neighbouring frames as seen from the boundary poses, in speeds: a hundredth of a metre a frame is fast.
        past = self.neighbour_in((history - base[:, :1]) * RATE_HZ / unit)
        future = self.neighbour_in((after - base[:, -1:]) * RATE_HZ / unit)
        length = self.length_in(4 * (steps[:, None, None] / 60 - 1))
        sequence = torch.cat([past, tokens, future], dim=1) + self.place + length
        features = self.norm(self.encoder(sequence))[:, history.shape[1] : -after.shape[1]]
        return self.out(features) * inner_mask(base.shape[1])


def inner_mask(token_count: int) -> Tensor:
    """(n, 1) 0 at the two boundary tokens, 1 between them."""
    mask = torch.ones(token_count, 1)
    mask[0] = mask[-1] = 0
    return mask


def signal_and_noise(level: Tensor) -> tuple[Tensor, Tensor]:
    """Share of signal and of noise at a level in [0, 1]: a cosine schedule that preserves variance."""
    return torch.cos(level * math.pi / 2), torch.sin(level * math.pi / 2)


def _units(tokens: Tensor) -> Tensor:
    unit = torch.ones(TOKEN_SIZE, dtype=tokens.dtype)
    unit[[0, 1, 2, 10, 11, 12]] = POSITION_UNIT_M
    return unit


def _waves(level: Tensor) -> Tensor:
    frequency = 2.0 ** torch.arange(8, dtype=level.dtype)
    angle = level[..., None] * frequency * math.pi / 4
    return torch.cat([torch.sin(angle), torch.cos(angle)], dim=-1)
