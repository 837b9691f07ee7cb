"""In what a trial is seen: one of training's looks, the same in every shift, with one thing changed where that is the shift."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, get_args

import numpy as np
from pydantic import TypeAdapter

from sim1.episode import read_episode
from sim1.policy.image.clips import Clip as TrainingClip
from sim1.policy.image.shifts import IN_DOMAIN, shifted_looks
from sim1.policy.image.trained_looks import about_clip, rendered_like
from sim1.policy.image_trials.stage import ImageShift
from sim1.policy.trials import Trial
from sim1.render.appearance import Appearance
from sim1.render.job import Clip
from sim1.render.looks.draw import Looks
from sim1.render.looks.rooms import light_of
from sim1.render.stage import RenderConfig
from sim1.stage import random_stream

SHIFTS: tuple[str, ...] = get_args(ImageShift.__value__)
TURNS = ("viewpoint_down", "viewpoint_up")
LOOK_COLUMNS = ("trained_look", "fabric", "table", "room", "light", "elevation_deg")


@dataclass(frozen=True, kw_only=True)
class Wardrobe:
    """Looks of a garment that the policy was trained on, and how they were rendered."""

    clips: Mapping[str, dict[str, Any]]  # key of a training clip -> its record, see `appearance_file`
    task: str  # in words
    config: RenderConfig  # of all of them

    @property
    def look_count(self) -> int:
        """How many different ones: trajectories may share them."""
        return len({json.dumps(record["appearance"], sort_keys=True) for record in self.clips.values()})

    @classmethod
    def of(cls, rendered: Path, train: Sequence[TrainingClip]) -> "Wardrobe":
        """Of the training clips of one garment, at least one; `rendered`: its artifact of `rendered_episodes`.

        Raises:
            BadInput: a record is missing or damaged.
        """
        found = {
            f"{clip.trajectory.name}_v{clip.appearance}": about_clip(rendered, clip.trajectory.name, clip.appearance)
            for clip in train
        }
        first = read_episode(rendered / "episodes" / train[0].trajectory.name)
        return cls(clips=found, task=first.about["task_text"], config=rendered_like(next(iter(found.values()))))


@dataclass(frozen=True, kw_only=True)
class Dress:
    """The look of one trial."""

    clip: Clip
    trained_look: str  # key of the training clip whose look it is, or was before the change

    @property
    def columns(self) -> dict[str, Any]:
        """`LOOK_COLUMNS` of the trial's row."""
        look = self.clip.appearance
        return {
            "trained_look": self.trained_look,
            "fabric": look.fabric.name,
            "table": look.table.name,
            "room": look.room.name,
            "light": light_of(look.room.name),
            "elevation_deg": float(round(np.degrees(look.elevation_offset_rad), 6)),
        }


def dress(
    trial: Trial, wardrobe: Wardrobe, known: Looks, *, seed: int, viewpoint_rad: float, frame_count: int
) -> Dress:
    """What a trial looks like. Those of one network and number differ in what their shift changes alone, noise of the pictures included.

    Args:
        trial: which; the viewpoint is lower in even ones and higher in odd ones.
        wardrobe: of its garment.
        known: what changed looks are drawn from.
        seed: of all draws.
        viewpoint_rad: see `shifted_looks`.
        frame_count: pictures at most.

    Raises:
        BadInput: there is but one light, or no table that a fabric stands out from.
    """
    chance = partial(random_stream, seed, "trial look", trial.garment, trial.model.seed, trial.number)
    keys = sorted(wardrobe.clips)
    key = keys[int(chance("base").integers(len(keys)))]
    base = TypeAdapter(Appearance).validate_python(wardrobe.clips[key]["appearance"])
    jitter_rad = np.radians(wardrobe.config.elevation_jitter_deg)
    looks = shifted_looks(base, chance, known, viewpoint_rad=viewpoint_rad, jitter_rad=jitter_rad)
    changes = {"texture": "texture", "lighting": "lighting", "viewpoint": TURNS[trial.number % len(TURNS)]}
    clip = Clip(
        garment=trial.garment,
        episode=f"trial_{trial.model.seed}_{trial.number:04d}",
        variant=SHIFTS.index(trial.shift),
        frame_count=frame_count,
        stride=wardrobe.clips[key]["stride"],
        appearance=looks[changes.get(trial.shift, IN_DOMAIN)],
    )
    return Dress(clip=clip, trained_look=key)
