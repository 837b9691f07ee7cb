"""Stage `image_trials`: the image policies drive, and see pictures that are rendered of the cell as it is."""

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from sim1.policy.stage import Factors
from sim1.stage import Facts, Finding, Inputs, distinct, stage_config

type ImageShift = Literal["in-domain", "spatial", "texture", "lighting", "viewpoint"]


@stage_config
class ImageTrialsConfig:
    """How often, in what, and for how long the policy drives."""

    seed: int = (
        0  # of placements and looks; with the seed of stage `policy`, networks of one seed meet the same placements
    )
    trial_count: int = Field(2, ge=0)  # per garment, network and shift
    shifts: Annotated[tuple[ImageShift, ...], AfterValidator(distinct)] = (
        "in-domain",
        "spatial",
        "texture",
        "lighting",
        "viewpoint",
    )  # what is other than in training
    evaluate_garment_count: int = Field(1, ge=0)
    evaluate_first: tuple[str, ...] = ("towel",)  # preferred for it, where the policy was trained on them; then by name
    trials_in: Literal["reality", "simulator"] = "reality"  # the stand-in, or the cell that made the training data
    replan_s: float = Field(
        0.1, gt=0
    )  # a new chunk, and a picture for it, that often; at least one frame of the dataset
    ensemble_decay: float = Field(0.1, ge=0)  # weight exp(-decay * age in chunks) of older chunks; large: newest alone
    laid_m: float = Field(0.01, ge=0)  # all shifts but spatial: laid down by hand at the same place, within this radius
    shift_m: float = Field(0.08, ge=0)  # spatial: moved within this radius (paper, section 4.1: 8 cm)
    turn_rad: float = Field(math.radians(15), ge=0)  # and turned within this angle (paper: 15 degrees)
    viewpoint_deg: float = Field(5.0, ge=0, le=30)  # viewpoint: below and above all that training has seen, in turn
    friction_factors: Factors = (0.6, 1.6)  # texture: of all contacts, in turn
    time_factor: float = Field(1.2, gt=0)  # a trial lasts this many times its garment's longest real demonstration
    device: Literal["auto", "cpu", "gpu"] = "auto"  # of the policy; gpu is not deterministic
    processes: int = Field(0, ge=0, exclude=True)  # trials at once; 0: one per core; no part of the recipe


def image_trials(inputs: Inputs, out: Path, config: ImageTrialsConfig) -> Facts:
    """Let the image policy's networks drive in every shift, with pictures rendered as the dataset's were, and count what they fold.

    Trials that `out` already holds of an interrupted run are kept.

    Raises:
        BadInput: an input is missing or damaged, or the policy cannot drive or has no GPU.
        BlenderFailed: a process of Blender could not see.
    """
    from sim1.policy.image_trials.experiment import run_experiment

    return run_experiment(inputs, out, config)


def check_image_trials(artifact: Path) -> list[Finding]:
    """Every trial is accounted for, in pairs that differ in their shift alone, and its figures are finite and on the page."""
    from sim1.policy.image_trials.checks import check_experiment

    return check_experiment(artifact)
