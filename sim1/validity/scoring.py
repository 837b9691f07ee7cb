"""Training of the discriminator, its figures on clips that it has not seen, and the threshold that follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from sklearn.metrics import roc_auc_score
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits

from sim1.progress import track
from sim1.statistics import wilson_interval
from sim1.validity.discriminator import VideoDiscriminator


@dataclass(frozen=True, kw_only=True)
class LabelledClip:
    """A clip as the network sees it."""

    name: str
    frames: np.ndarray  # (t, h, w, 3) u8
    success: bool
    sources: frozenset[str]


def padded(clips: Sequence[np.ndarray]) -> tuple[Tensor, Tensor]:
    """Clips (t, h, w, 3) u8 of different lengths as video (b, t, 3, h, w) in [0, 1] and valid (b, t)."""
    length = max(len(clip) for clip in clips)
    video = torch.zeros(len(clips), length, 3, *clips[0].shape[1:3])
    valid = torch.zeros(len(clips), length, dtype=torch.bool)
    for index, clip in enumerate(clips):
        video[index, : len(clip)] = torch.from_numpy(clip.copy()).permute(0, 3, 1, 2) / 255
        valid[index, : len(clip)] = True
    return video, valid


def split_by_source(clips: Sequence[LabelledClip]) -> tuple[list[LabelledClip], list[LabelledClip], str | None]:
    """Training clips, held-out clips, and the demonstration held out: no clip made of it is trained on.

    Of the demonstrations that leave both outcomes on both sides, the one whose share comes nearest to 0.3; without any,
    nothing is held out.
    """
    best, best_cost = (list(clips), [], None), np.inf
    for source in sorted(set().union(*(clip.sources for clip in clips))):
        test = [clip for clip in clips if source in clip.sources]
        train = [clip for clip in clips if source not in clip.sources]
        if len({clip.success for clip in test}) == 2 and len({clip.success for clip in train}) == 2:
            cost = abs(len(test) / len(clips) - 0.3)
            if cost < best_cost:
                best, best_cost = (train, test, source), cost
    return best


def train_discriminator(
    clips: Sequence[LabelledClip], *, width: int, layer_count: int, step_count: int, batch_size: int,
    learning_rate: float, rng: np.random.Generator,
) -> tuple[VideoDiscriminator, list[float]]:  # fmt: skip
    """Fit on balanced batches: half successes, half failures, each with a random number of leading frames dropped."""
    torch.manual_seed(int(rng.integers(2**31)))
    network = VideoDiscriminator(width, layer_count)
    optimizer = torch.optim.AdamW(network.parameters(), lr=learning_rate, weight_decay=1e-3)
    groups = [[clip for clip in clips if clip.success is wanted] for wanted in (True, False)]
    losses = []
    for _ in track(range(step_count), "training the discriminator"):
        picked = [group[int(rng.integers(len(group)))] for group in groups for _ in range(batch_size // 2)]
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


@dataclass(frozen=True, kw_only=True)
class Operating:
    """A threshold and what it does to held-out clips."""

    threshold: float
    precision: float
    recall: float
    accepted: int
    accepted_success: int
    success_count: int


def threshold_for(score: np.ndarray, success: np.ndarray, precision: float) -> Operating | None:
    """Lowest threshold whose precision is at least the wanted one: most recall. None where no threshold has it.

    It lies half-way between the lowest score that it accepts and the next lower one.
    """
    levels = np.sort(np.unique(score))
    for threshold, below in zip(levels, [0.0, *levels[:-1]], strict=True):
        taken = score >= threshold
        right = int(success[taken].sum())
        if right and right / taken.sum() >= precision:
            return Operating(
                threshold=float(threshold + below) / 2,
                precision=right / int(taken.sum()),
                recall=right / int(success.sum()),
                accepted=int(taken.sum()),
                accepted_success=right,
                success_count=int(success.sum()),
            )
    return None


def held_out_figures(score: np.ndarray, success: np.ndarray, operating: Operating | None) -> dict[str, object]:
    """ROC area, and precision and recall with Wilson intervals at the threshold."""
    figures: dict[str, object] = {"success_count": int(success.sum()), "failure_count": int((~success).sum())}
    if len(set(success.tolist())) == 2:
        figures["roc_area"] = float(roc_auc_score(success, score))
    if operating is not None:
        figures |= {
            "precision": operating.precision,
            "precision_ci95": list(wilson_interval(operating.accepted_success, operating.accepted)),
            "recall": operating.recall,
            "recall_ci95": list(wilson_interval(operating.accepted_success, operating.success_count)),
        }
    return figures
