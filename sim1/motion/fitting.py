"""The work of stage motion_model: from the pool to a model, its training record and pictures."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import torch

from sim1.episode import RATE_HZ
from sim1.motion.durations import fitted_durations
from sim1.motion.model import MotionModel, sliced, transition, write_model
from sim1.motion.pictures import draw_samples, draw_training
from sim1.motion.pool import read_pool
from sim1.motion.poses import TOKEN_SIZE, ToolPath
from sim1.motion.training import PROBE_COUNT, Trained, train
from sim1.motion.transitions import Transition, bank_of, residual_scale, transitions_of
from sim1.stage import BadInput, Facts, random_stream

if TYPE_CHECKING:
    from sim1.motion.stage import MotionModelConfig


def fit_model(pool: Path, garment: str, config: MotionModelConfig, out: Path) -> Facts:
    """Fit, sample, measure and write everything that the stage makes, from the demonstrations that succeeded.

    Raises:
        BadInput: no demonstration succeeded, or none of those that did has a transition that is long enough.
    """
    torch.set_num_threads(1)  # the sizes are small, and other garments train beside this one
    segments = read_pool(pool)
    good = [part for part in segments if part.success]
    if not good:
        raise BadInput(
            f"{pool}: success is false for all {len({part.demo for part in segments})} demonstrations; "
            "record one that succeeds and make segment_pool again"
        )
    transitions = transitions_of(good)
    if not transitions:
        raise BadInput(
            f"{pool}: no moving segment of a successful demonstration is long enough to learn from; "
            "check the thresholds of segment_pool"
        )
    rng = random_stream(config.seed, garment, "motion_model")
    trained, scale = None, np.ones((config.token_count, TOKEN_SIZE))
    if config.method == "diffusion":
        trained, scale = _train(transitions, config, rng)
    model = MotionModel(
        method=config.method,
        durations=fitted_durations(
            [(item.history, item.after) for item in transitions],
            [(len(item.path) - 1) / RATE_HZ for item in transitions],
        ),
        network=trained.network if trained else None,
        scale=scale,
        width=config.width,
        layer_count=config.layer_count,
        token_count=config.token_count,
        shape_count=len(trained.network.shapes) if trained else config.shape_count,  # few examples have few
        sampling_steps=config.sampling_steps,
    )
    write_model(out, model)
    record = _measured(model, transitions, rng, out) | _training_record(trained, out)
    record |= {"method": config.method, "transition_count": len(transitions)}
    (out / "training.json").write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")
    facts = {key: value for key, value in record.items() if not isinstance(value, list) and value is not None}
    return facts | {"duration_rest_s": model.durations.rest_s, "duration_s_per_m": model.durations.s_per_m}


def _train(transitions: list[Transition], config: MotionModelConfig, rng: np.random.Generator) -> tuple[Trained, np.ndarray]:  # fmt: skip
    used, held_out = held_apart(transitions)
    sizes = (config.token_count, rng)
    bank = bank_of(used, config.bank_count, *sizes)
    scale = residual_scale(bank.residual)
    trained = train(
        bank,
        bank_of(held_out, PROBE_COUNT, *sizes) if held_out else None,
        scale,
        width=config.width,
        layer_count=config.layer_count,
        shape_count=config.shape_count,
        step_count=config.step_count,
        batch_size=config.batch_size,
        learning_rate=config.learning_rate,
        rng=rng,
    )
    return trained, scale


def held_apart(transitions: list[Transition]) -> tuple[list[Transition], list[Transition]]:
    """Those to train on, and those of every fifth demonstration; none of fewer than four, where training needs them all.

    Whole demonstrations: ways out and back of one run are alike, and the one would foretell the other.
    """
    out = set(sorted({item.demo for item in transitions})[3::5])
    return [item for item in transitions if item.demo not in out], [item for item in transitions if item.demo in out]


def _training_record(trained: Trained | None, out: Path) -> dict[str, object]:
    if trained is None:
        return {}
    draw_training(out / "training.png", trained.losses, trained.trivial_loss)
    return {
        "losses": [round(loss, 5) for loss in trained.losses],
        "loss_end": float(np.mean(trained.losses[-max(len(trained.losses) // 10, 1) :])),
        "loss_trivial": trained.trivial_loss,
        "held_out_loss": trained.held_out_loss,
        "held_out_trivial": trained.held_out_trivial,
        "from_noise_loss": trained.from_noise_loss,
        "from_noise_trivial": trained.from_noise_trivial,
    }


def _measured(model: MotionModel, transitions: list[Transition], rng: np.random.Generator, out: Path) -> dict[str, float]:  # fmt: skip
    """Samples between the demonstrations' own boundary poses: errors there, jerk against theirs, a picture."""
    pairs, errors, ratios = [], [], []
    for item in transitions:
        samples = [_sample(model, item, rng) for _ in range(3)]
        pairs.append((item.path, samples))
        errors += [_boundary_error(item.path, sample) for sample in samples] if model.method != "slicing" else [0.0]
        ratios += [jerk(sample) / max(jerk(item.path), 1e-9) for sample in samples]
    shown = np.unique(np.linspace(0, len(pairs) - 1, 4).round().astype(int))
    title = f"Demonstrated transitions (black) and {model.method.replace('_', ' ')} between the same poses (blue)"
    draw_samples(out / "samples.png", title, [pairs[index] for index in shown])
    return {"boundary_error": max(errors), "jerk_ratio": float(np.median(ratios))}


def _sample(model: MotionModel, item: Transition, rng: np.random.Generator) -> ToolPath:
    if model.method == "slicing":
        return sliced(item.path, np.eye(4), item.path[:1], 1)
    steps = model.durations.sample_steps(item.history, item.after, rng)
    return transition(model, item.history, item.after, steps, rng)


def _boundary_error(given: ToolPath, sample: ToolPath) -> float:
    """Largest difference of any number of the two boundary poses."""
    return max(
        float(np.abs(getattr(given, name)[frame] - getattr(sample, name)[frame]).max())
        for name in ("position_m", "rotation", "openness")
        for frame in (0, -1)
    )


def jerk(path: ToolPath) -> float:
    """Root mean square jerk of both tools [m/s^3]."""
    third = np.diff(path.position_m, n=3, axis=0) * RATE_HZ**3
    return float(np.sqrt((third**2).sum(axis=-1).mean()))
