"""Where a training is: written whole or not at all, so that a killed run goes on as if nothing had happened."""

import json
import shutil
from pathlib import Path

import safetensors
import safetensors.torch
from lerobot.common.train_utils import load_training_state, save_training_state
from lerobot.policies.pretrained import PreTrainedPolicy
from torch.optim import Optimizer
from torch.optim.lr_scheduler import LRScheduler

from sim1.stage import BadInput

WEIGHTS, LOSSES, HALF = "model.safetensors", "losses.json", "next.part"


def save_checkpoint(
    folder: Path, policy: PreTrainedPolicy, optimizer: Optimizer, scheduler: LRScheduler | None, losses: list[float]
) -> None:
    """Keep weights, optimiser, schedule and random states after `len(losses)` steps in `folder`, in place of the last ones."""
    half = folder / HALF
    shutil.rmtree(half, ignore_errors=True)
    half.mkdir(parents=True)
    safetensors.torch.save_model(policy, str(half / WEIGHTS))
    save_training_state(half, len(losses), optimizer, scheduler)
    (half / LOSSES).write_text(json.dumps(losses))
    before = _whole(folder)
    half.rename(folder / f"{len(losses):08d}")
    for old in before:
        shutil.rmtree(old)


def load_checkpoint(
    folder: Path, policy: PreTrainedPolicy, optimizer: Optimizer, scheduler: LRScheduler | None
) -> list[float]:
    """Put everything back as it was; the losses so far, one per step: an empty list where nothing was kept.

    Raises:
        BadInput: what was kept is damaged.
    """
    kept = _whole(folder)
    if not kept:
        return []
    try:
        safetensors.torch.load_model(policy, kept[-1] / WEIGHTS)
        load_training_state(kept[-1], optimizer, scheduler)
        return json.loads((kept[-1] / LOSSES).read_text())
    except (OSError, ValueError, KeyError, RuntimeError, safetensors.SafetensorError) as error:
        raise BadInput(
            f"{kept[-1]}: the interrupted training cannot go on ({error}); remove it with `sim1 clean` and run again"
        ) from error


def _whole(folder: Path) -> list[Path]:
    """Checkpoints that were finished, oldest first."""
    return sorted(path for path in folder.glob("[0-9]*") if path.is_dir())
