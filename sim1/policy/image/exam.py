"""What every network of an image policy is tried on: what was held out, that in changed looks, and without a picture."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sim1.policy.image.build import Trained
from sim1.policy.image.clips import Clip
from sim1.policy.image.evaluation import errors_of, without_pictures
from sim1.policy.image.measures import BLANK, DATASET
from sim1.policy.image.shifts import IN_DOMAIN, TITLES
from sim1.progress import within


@dataclass(frozen=True, kw_only=True)
class Exam:
    """Clips, and how a policy is tried on them."""

    dataset: Path  # artifact with the held-out clips as they are
    held_out: Sequence[Clip]
    views: Path  # folder with `lerobot/`, of those that were rendered anew
    shown: Sequence[Clip]  # its clips, whose appearance is the place of their look in `TITLES`
    stride: int  # frames of a trajectory for one of these
    colors: Mapping[str, np.ndarray]  # camera -> (3, 1, 1), what stands for no picture
    chunk_frames: int
    every: int
    batch: int
    workers: int
    seed: int  # of policies that answer by chance

    def errors(self, trained: Trained) -> list[dict[str, Any]]:
        """A row per clip (`sim1.policy.image.evaluation.ERROR_COLUMNS`)."""
        how = {
            "chunk_frames": self.chunk_frames,
            "every": self.every,
            "batch": self.batch,
            "workers": self.workers,
            "seed": self.seed,
        }
        looks = {shift: [clip for clip in self.shown if clip.appearance == at] for at, shift in enumerate(TITLES)}
        with within(0.0, 0.5):
            rows = errors_of(trained, self.dataset, {DATASET: self.held_out}, **how)
        with within(0.5, 0.9):
            rows += errors_of(trained, self.views, looks, stride=self.stride, **how)
        with within(0.9, 1.0):
            blank, see = {BLANK: looks[IN_DOMAIN]}, without_pictures(self.colors)
            rows += errors_of(trained, self.views, blank, stride=self.stride, see=see, **how)
        return rows
