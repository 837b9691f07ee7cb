"""What must hold in the artifact of stage `image_policy`."""

import hashlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.policy.checks import page_findings
from sim1.policy.counting import read_figures, read_table
from sim1.policy.image.build import load
from sim1.policy.image.measures import ALL_TITLES, BLANK, DATASET, SCHEMA
from sim1.policy.image.shifts import TITLES
from sim1.stage import BadInput, Finding


def check_experiment(artifact: Path) -> list[Finding]:
    """Findings of stage `image_policy`."""
    about = read_figures(artifact / "image_policy.json", SCHEMA, "image_policy")
    errors = read_table(artifact / "open_loop.parquet")
    losses = read_table(artifact / "training.parquet")
    seeds = [network["seed"] for network in about["networks"]]
    return [
        *_policies(artifact / "policies", seeds, about["parameter_count"]),
        _losses(losses, seeds, about["training"]["steps"]),
        *_counts(errors, about),
        *page_findings(artifact, [ALL_TITLES[point["pictures"]] for point in about["points"]] + ["scripted expert"]),
        *_skill(about),
    ]


def _policies(folder: Path, seeds: Sequence[int], parameter_count: int) -> list[Finding]:
    """Lerobot's own loaders read what was saved, and networks are as different as their seeds."""
    odd, bad, tensors, known = [], [], 0, set()
    for seed in seeds:
        try:
            trained = load(folder / str(seed), "cpu")
        except BadInput as error:
            return [Finding(name="lerobot_loads_it_again", passed=False, detail=str(error))]
        weights = trained.policy.state_dict()
        tensors += len(weights)
        bad += [f"{name} of {seed}" for name, tensor in weights.items() if not tensor.isfinite().all()]
        count = sum(item.numel() for item in trained.policy.parameters())
        odd += [f"{count} parameters of {seed}"] if count != parameter_count else []
        known.add(hashlib.sha256((folder / str(seed) / "model.safetensors").read_bytes()).hexdigest())
    return [
        Finding(
            name="lerobot_loads_it_again",
            passed=not odd,
            detail=f"{', '.join(odd) or f'{len(seeds)} networks'}, {parameter_count} parameters were trained",
        ),
        Finding(name="weights_finite", passed=not bad, detail=", ".join(bad[:3]) or f"{tensors} tensors"),
        Finding(
            name="networks_differ",
            passed=len(known) == len(seeds),
            detail=f"{len(known)} of {len(seeds)} are different",
        ),
    ]


def _losses(losses: pd.DataFrame, seeds: Sequence[int], steps: int) -> Finding:
    found = {seed: int(np.isfinite(own).sum()) for seed, own in losses.groupby("seed")["loss"]}
    return Finding(
        name="every_step_has_a_loss",
        passed=found == dict.fromkeys(seeds, steps) and len(losses) == steps * len(seeds),
        detail=f"finite losses by seed: {found}, of {steps} steps",
    )


def _counts(errors: pd.DataFrame, about: dict) -> list[Finding]:
    """A row per network and held-out clip or view, no picture included; the same number of views in every look."""
    seeds = [network["seed"] for network in about["networks"]]
    found = errors.groupby("seed")["pictures"].value_counts().to_dict()
    each = about["view_clips"] // len(TITLES)
    planned = {DATASET: about["held_out_clips"], **dict.fromkeys(TITLES, each), BLANK: each}
    planned = {(seed, name): count for seed in seeds for name, count in planned.items() if count}
    values = errors.filter(like="error").to_numpy(float)
    held_out = set(about["held_out"])
    strangers = {f"{row.garment}/{row.trajectory}" for row in errors.itertuples()} - held_out
    return [
        Finding(
            name="every_error_measured",
            passed=found == planned and bool(np.isfinite(values).all()),
            detail=f"rows {dict(sorted(found.items()))}, planned {dict(sorted(planned.items()))}",
        ),
        Finding(
            name="held_out_alone_is_tested",
            passed=not strangers,
            detail=f"{len(held_out)} held-out trajectories; tested besides: {sorted(strangers)[:3] or 'none'}",
        ),
    ]


def _skill(about: dict) -> list[Finding]:
    plain = next((point for point in about["points"] if point["pictures"] == DATASET), None)
    if plain is None:
        return []
    error, hold = np.degrees(plain["joint_rad"]["value"]), np.degrees(plain["hold_joint_rad"])
    return [
        Finding(
            name="better_than_standing_still",
            passed=bool(error < hold),
            detail=f"held-out joint error {error:.2f} degrees, standing still {hold:.2f} degrees",
            blocking=False,  # with few trajectories and steps this is a result, not a defect
        )
    ]
