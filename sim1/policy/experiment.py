"""The work of stage `policy`: split, train at several sizes, test on held-out trajectories, drive a simulated cell."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import pandas as pd

from sim1.picture_file import save_figure
from sim1.policy.episodes import Trajectory, read_keypoints, read_rate_hz, read_trajectories
from sim1.policy.model import SCHEMA, ChunkPolicy, save_policy
from sim1.policy.pictures import draw_command, draw_trials
from sim1.policy.rollout import Driving
from sim1.policy.split import GarmentSplit, nested_order, split_garment, usable_sizes
from sim1.policy.stage import PolicyConfig
from sim1.policy.training import TrainingPlan, open_loop_error, train
from sim1.policy.trials import TRIAL_COLUMNS, Trials
from sim1.progress import report
from sim1.stage import BadInput, Facts, Inputs, only, random_stream

OPEN_LOOP_COLUMNS = (
    "size", "seed", "garment", "trajectory", "joint_error_rad", "openness_error", "hold_joint_error_rad",
)  # fmt: skip
TRAINING_SHARE = 0.2  # of the progress bar; trials in the simulator take the rest


def run_experiment(inputs: Inputs, out: Path, config: PolicyConfig) -> Facts:
    """Write models, `policy.json`, `open_loop.parquet`, `evaluation.parquet` and pictures into `out`."""
    dataset = only(inputs, "dataset")
    rate_hz = read_rate_hz(dataset)
    trajectories = read_trajectories(dataset)
    garments = sorted({item.garment for item in trajectories})
    splits = {
        name: split_garment(
            [item for item in trajectories if item.garment == name],
            config.test_share,
            random_stream(config.seed, "split", name),
        )
        for name in garments
    }
    order = nested_order(
        [item for split in splits.values() for item in split.train], random_stream(config.seed, "order")
    )
    held_out = [item for split in splits.values() for item in split.test]
    sizes = usable_sizes(config.sizes, len(order))
    if not sizes:
        raise BadInput(f"{dataset}: no trajectory to train on; generate more, or ask for sizes of at least 1")
    plan = TrainingPlan(
        steps=config.steps,
        batch=config.batch,
        learning_rate=config.learning_rate,
        input_noise=config.input_noise,
        chunk_frames=max(2, round(config.chunk_s * rate_hz)),
        width=config.width,
        depth=config.depth,
    )
    models = _train_all(order, garments, sizes, config.seeds, plan)
    errors = [
        {
            "size": size,
            "seed": seed,
            "garment": item.garment,
            "trajectory": item.name,
            **asdict(open_loop_error(model, item)),
        }
        for (size, seed), model in models.items()
        for item in held_out
    ]
    driving = Driving(
        rate_hz=rate_hz,
        replan_frames=min(max(1, round(config.replan_s * rate_hz)), plan.chunk_frames - 1),
        decay=config.ensemble_decay,
    )
    duration_s = config.time_factor * max(len(item.state) for item in order) / rate_hz
    chosen = trial_models(sizes, config)
    driven = trial_garments(garments, config)
    trials = Trials(inputs=inputs, driving=driving, duration_s=duration_s, config=config)
    keypoints = {name: read_keypoints(dataset, name) for name in garments}
    tried = trials.run({key: models[key] for key in chosen}, driven, keypoints, _rest_of_progress)

    (out / "policies").mkdir()
    for (size, seed), model in models.items():
        save_policy(out / "policies" / f"{size}_{seed}.safetensors", model)
    pd.DataFrame(errors, columns=list(OPEN_LOOP_COLUMNS)).to_parquet(out / "open_loop.parquet", index=False)
    pd.DataFrame(tried.rows, columns=list(TRIAL_COLUMNS)).to_parquet(out / "evaluation.parquet", index=False)
    about = {
        "schema": SCHEMA,
        "rate_hz": rate_hz,
        "trajectory_count": len(trajectories),
        "available_count": len(order),
        "held_out_count": len(held_out),
        "sizes": sizes,
        "requested_sizes": list(config.sizes),
        "seeds": list(config.seeds),
        "splits": [_split_row(name, split) for name, split in splits.items()],
        "training": asdict(plan),
        "driving": asdict(driving),
        "training_sets": {str(size): [f"{item.garment}/{item.name}" for item in order[:size]] for size in sizes},
        "trial_duration_s": duration_s,
        "trials": {
            "worlds": sorted({row["world"] for row in tried.rows}),
            "garments": driven,
            "models": [list(key) for key in chosen],
            "each": config.trial_count,
        },
    }
    (out / "policy.json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")
    largest = models[sizes[-1], config.seeds[0]]
    save_figure(draw_command(largest, (held_out or order)[0], held_out=bool(held_out)), out / "command.png", dpi=110)
    if tried.strips:
        save_figure(draw_trials(tried.strips), out / "trials.png", dpi=110)
    return {
        "model_count": len(models),
        "sizes": ", ".join(map(str, sizes)),
        "held_out_trajectory_count": len(held_out),
        "held_out_joint_error_rad": _mean([row["joint_error_rad"] for row in errors if row["size"] == sizes[-1]]),
        "standing_still_joint_error_rad": _mean([row["hold_joint_error_rad"] for row in errors]),
        "trial_garments": ", ".join(driven),
        "trials_in": ", ".join(sorted({row["world"] for row in tried.rows})) or "none",
        "trial_count": len(tried.rows),
        "success_count": sum(row["success"] for row in tried.rows),
    }


def trial_models(sizes: Sequence[int], config: PolicyConfig) -> list[tuple[int, int]]:
    """(size, seed) of the models that drive: the largest size, the smallest, then those between from above."""
    ends = list(dict.fromkeys([sizes[-1], sizes[0], *reversed(sizes)]))[: config.evaluate_sizes]
    return [(size, seed) for size in sorted(ends) for seed in config.seeds[: config.evaluate_seeds]]


def trial_garments(garments: Sequence[str], config: PolicyConfig) -> list[str]:
    """Garments of the closed loop: the preferred ones that the dataset has, then the others by name."""
    preferred = [name for name in config.evaluate_first if name in garments]
    return [*preferred, *sorted(set(garments) - set(preferred))][: config.evaluate_garment_count]


def _train_all(
    order: Sequence[Trajectory], garments: Sequence[str], sizes: Sequence[int], seeds: Sequence[int], plan: TrainingPlan
) -> dict[tuple[int, int], ChunkPolicy]:
    keys = [(size, seed) for size in sizes for seed in seeds]
    models = {}
    for done, (size, seed) in enumerate(keys):
        report(TRAINING_SHARE * done / len(keys), 1.0, f"training on {size} trajectories, seed {seed}")
        models[size, seed] = train(order[:size], garments, plan, seed)
    return models


def _rest_of_progress(share: float, what: str) -> None:
    report(TRAINING_SHARE + (1 - TRAINING_SHARE) * share, 1.0, what)


def _split_row(name: str, split: GarmentSplit) -> dict[str, object]:
    return {
        "garment": name,
        "train": len(split.train),
        "held out": len(split.test),
        "split": split.kind,
        "held-out source": split.held_out_source,
    }


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None
