"""Training of the discriminator, and the scores that it gives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits

from sim1.progress import track
from sim1.validity.discriminator import VideoDiscriminator
from sim1.validity.parts import LabelledClip

if TYPE_CHECKING:
    from sim1.validity.stage import VideoDiscriminatorConfig


def padded(clips: Sequence[np.ndarray]) -> tuple[Tensor, Tensor]:
    """Clips (t, h, w, 3) u8 of different lengths as video (b, t, 3, h, w) in [0, 1] and valid (b, t)."""
    length = max(len(clip) for clip in clips)
    video = torch.zeros(len(clips), length, 3, *clips[0].shape[1:3])
    valid = torch.zeros(len(clips), length, dtype=torch.bool)
    for index, clip in enumerate(clips):
        video[index, : len(clip)] = torch.from_numpy(clip.copy()).permute(0, 3, 1, 2) / 255
        valid[index, : len(clip)] = True
    return video, valid


def train_discriminator(
    clips: Sequence[LabelledClip], config: VideoDiscriminatorConfig, rng: np.random.Generator
) -> tuple[VideoDiscriminator, list[float]]:
    """Fit on balanced batches: half successes, half failures, each with a random number of leading frames dropped."""
    torch.manual_seed(int(rng.integers(2**31)))
    network = VideoDiscriminator(config.width, config.layer_count)
    optimizer = torch.optim.AdamW(network.parameters(), lr=config.learning_rate, weight_decay=1e-3)
    groups = [[clip for clip in clips if clip.success is wanted] for wanted in (True, False)]
    losses = []
    for _ in track(range(config.step_count), "training the discriminator"):
        picked = [group[int(rng.integers(len(group)))] for group in groups for _ in range(config.batch_size // 2)]
        video, valid = padded([_varied(clip.frames, rng) for clip in picked])
        wanted = torch.tensor([float(clip.success) for clip in picked])
        loss = binary_cross_entropy_with_logits(network(video, valid), wanted)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        losses.append(loss.item())
    network.eval()
    return network, losses


def _varied(frames: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Clip with up to a quarter of its first frames dropped, brightness changed by up to a tenth, shifted by 2 px."""
    kept = frames[int(rng.integers(0, len(frames) // 4 + 1)) :]
    shifted = np.roll(kept, tuple(rng.integers(-2, 3, 2)), axis=(1, 2))
    return np.clip(shifted * rng.uniform(0.9, 1.1), 0, 255).astype(np.uint8)


def scores(network: VideoDiscriminator, clips: Sequence[np.ndarray]) -> np.ndarray:
    """Probability of being valid, (n,)."""
    with torch.no_grad():
        return np.array([float(torch.sigmoid(network(*padded([clip])))[0]) for clip in clips])
