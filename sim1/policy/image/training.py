"""Fits a policy of lerobot's to the pictures, with lerobot's own loss, optimiser and order of frames.

On the CPU the same seed gives the same bytes on one machine, with one thread, in however many runs: frames are drawn by a
function of seed and epoch, and what is random in the policy is restored with a checkpoint. A GPU sums in no fixed order.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import torch
from lerobot.configs import PreTrainedConfig
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.datasets.sampler import EpisodeAwareSampler, compute_sampler_state
from lerobot.utils.random_utils import seeded_context
from torch.optim import Optimizer

from sim1.policy.image.build import Trained, new_policy, processors
from sim1.policy.image.checkpoint import load_checkpoint, save_checkpoint
from sim1.policy.image.frames import Batch, KeptFrames, Statistics, loader, open_frames, seen_by
from sim1.policy.training import one_thread
from sim1.progress import report

SHOWN = 20  # steps whose mean loss is told


@dataclass(frozen=True, kw_only=True)
class TrainingPlan:
    """How a policy is fitted."""

    steps: int
    batch: int  # frames per step
    seed: int
    workers: int = 0  # processes that decode videos; the frames come in the same order
    checkpoint_s: float = 60.0  # between two checkpoints
    kept_mib: int = 0  # of decoded pictures, in each process that decodes


def train(
    dataset: Path,
    episodes: Sequence[int],
    config: PreTrainedConfig,
    weights: Path | None,
    fresh: Sequence[str],
    statistics: Statistics,
    plan: TrainingPlan,
    folder: Path,
) -> tuple[Trained, list[float]]:
    """Fit a policy to some episodes of a `dataset` artifact, going on where an earlier call was interrupted.

    Args:
        dataset: the artifact.
        episodes: the training part.
        config: of the policy.
        weights: published ones to start from, or None.
        fresh: see `new_policy`.
        statistics: of those episodes, for the normalisation.
        plan: how long, in which order.
        folder: keeps the state of the training while it is under way.

    Returns:
        The policy with its processors, and the loss of every step.
    """
    frames = open_frames(dataset, episodes, config)
    with one_thread(), seeded_context(plan.seed):
        policy = new_policy(config, weights, fresh)
        prepare, restore = processors(config, statistics)
        preset = config.get_optimizer_preset()
        optimizer = preset.build(policy.get_optim_params())
        schedule = config.get_scheduler_preset()
        scheduler = schedule.build(optimizer, plan.steps) if schedule else None
        losses = load_checkpoint(folder, policy, optimizer, scheduler)
        batches = _batches(frames, plan, first_step=len(losses))
        policy.train()
        kept_s = time.monotonic()
        while len(losses) < plan.steps:
            recent = losses[-SHOWN:]
            report(
                len(losses),
                plan.steps,
                f"training, step {len(losses) + 1} of {plan.steps}"
                + (f", loss {sum(recent) / len(recent):.3g}" if recent else ""),
            )
            batch = prepare(seen_by(config, next(batches)))
            losses.append(_step(policy, batch, optimizer, getattr(preset, "grad_clip_norm", 0.0)))
            if scheduler is not None:
                scheduler.step()
            if time.monotonic() - kept_s >= plan.checkpoint_s and len(losses) < plan.steps:
                save_checkpoint(folder, policy, optimizer, scheduler, losses)
                kept_s = time.monotonic()
    return Trained(policy=policy.eval(), prepare=prepare, restore=restore), losses


def _batches(frames: LeRobotDataset, plan: TrainingPlan, first_step: int) -> Iterator[Batch]:
    """Batches without end, from that of `first_step` on."""
    episodes = frames.meta.episodes
    sampler = EpisodeAwareSampler(
        episodes["dataset_from_index"],
        episodes["dataset_to_index"],
        episode_indices_to_use=frames.episodes,
        shuffle=True,
        seed=plan.seed,
        absolute_to_relative_idx=frames.absolute_to_relative_idx,
    )
    sampler.load_state_dict(compute_sampler_state(first_step, len(sampler), plan.batch, num_processes=1))
    batches = loader(
        KeptFrames(frames, plan.kept_mib * 2**20),
        batch_size=plan.batch,
        sampler=sampler,
        num_workers=plan.workers,
        persistent_workers=plan.workers > 0,
    )
    while True:
        yield from batches


def _step(policy: torch.nn.Module, batch: Batch, optimizer: Optimizer, clip_norm: float) -> float:
    loss, _ = policy(batch)
    loss.backward()
    if clip_norm > 0:
        torch.nn.utils.clip_grad_norm_(policy.parameters(), clip_norm)
    optimizer.step()
    optimizer.zero_grad()
    return float(loss.detach())
