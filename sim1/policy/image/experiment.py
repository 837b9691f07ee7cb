"""The work of stage `image_policy`: split, render changed pictures, train, test, report."""

import hashlib
import json
import math
import shutil
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sim1.picture_file import save_figure
from sim1.policy.counting import read_table
from sim1.policy.episodes import read_rate_hz
from sim1.policy.image.build import Trained, load, policy_config, save
from sim1.policy.image.clips import Clip, Parts, clips_of, split_clips
from sim1.policy.image.evaluation import ERROR_COLUMNS, errors_of, without_pictures
from sim1.policy.image.frames import looks_back, read_features, training_statistics
from sim1.policy.image.measures import BLANK, DATASET, SCHEMA, Point, measure, of_pictures
from sim1.policy.image.needs import choose_device, weights_folder
from sim1.policy.image.page import write_page
from sim1.policy.image.pictures import draw_errors, draw_looks, draw_loss
from sim1.policy.image.policy_file import find_policy
from sim1.policy.image.shifts import IN_DOMAIN, TITLES
from sim1.policy.image.stage import ImagePolicyConfig
from sim1.policy.image.training import TrainingPlan, train
from sim1.policy.image.views import choose_trajectories, write_views
from sim1.progress import report, within
from sim1.stage import BadInput, Facts, Inputs, only

POLICY, VIEWS, FRAMES, TRAINING = "policy", "views", "frames", "training"  # folders; the last two while at work
BEGUN_FROM = "weights.sha256"  # file in TRAINING, and beside the policy once there is one
RENDERED, TRAINED = 0.3, 0.9  # shares of the progress that are reached


def run_experiment(inputs: Inputs, out: Path, config: ImagePolicyConfig) -> Facts:
    """Write policy, views, errors, page and pictures into `out`."""
    report(0.0, 1.0, "reading the dataset")
    dataset = only(inputs, "dataset")
    path, file = find_policy(only(inputs, "policies"), config.policy)
    device = choose_device(path, file, config.device)
    weights = weights_folder(path, file.needs.weights) if file.needs.weights else None
    fresh = file.needs.weights.fresh if file.needs.weights else ()
    rate_hz = read_rate_hz(dataset)
    chunk_frames = max(2, round(config.chunk_s * rate_hz))
    features = read_features(dataset)
    settings = policy_config(path, file, config.size, features=features, chunk_frames=chunk_frames, device=device)
    parts = split_clips(dataset, config.test_share, config.seed)

    # A policy that does not look back needs no frames between those that it is tried on.
    stride = 1 if looks_back(settings) else math.gcd(config.evaluate_every, rate_hz)
    shown = _views(inputs, parts, out, stride, config)
    episodes = [clip.episode_index for clip in parts.train]
    statistics = training_statistics(dataset, episodes)
    plan = TrainingPlan(
        steps=config.steps,
        batch=config.batch,
        seed=config.seed,
        workers=config.workers,
        checkpoint_s=config.checkpoint_s,
    )
    with within(RENDERED if shown else 0.0, TRAINED):
        if not (out / POLICY).exists():
            begun_from = _begun_from(out / TRAINING, weights) if weights else None
            _keep(
                out, *train(dataset, episodes, settings, weights, fresh, statistics, plan, out / TRAINING), begun_from
            )
        trained = load(out / POLICY, device)
    losses = read_table(out / "training.parquet")["loss"].tolist()

    colors = {name: statistics[name]["mean"] for name in settings.image_features}
    with within(TRAINED, 1.0):
        errors = _errors(out, dataset, trained, parts.held_out, shown, stride, colors, chunk_frames, config)
    points = measure(errors, config.seed)
    about = {
        "schema": SCHEMA,
        "policy": config.policy,
        "title": file.title,
        "type": settings.type,
        "size": config.size,
        "device": device,
        "parameter_count": sum(item.numel() for item in trained.policy.parameters()),
        "inputs": sorted(settings.input_features),
        "weights_sha256": (out / BEGUN_FROM).read_text() if weights else None,
        "rate_hz": rate_hz,
        "chunk_frames": chunk_frames,
        "training": {"steps": plan.steps, "batch": plan.batch, "seed": plan.seed},
        "loss": {"first": _mean(losses[: _window(losses)]), "last": _mean(losses[-_window(losses) :])},
        "train_count": _trajectory_count(parts.train),
        "train_clips": len(parts.train),
        "held_out_count": _trajectory_count(parts.held_out),
        "held_out_clips": len(parts.held_out),
        "held_out": sorted({f"{clip.trajectory.garment}/{clip.trajectory.name}" for clip in parts.held_out}),
        "view_clips": len(shown),
        "viewpoint_deg": config.viewpoint_deg,
        "elevation_offset_deg": _elevations_deg(out) if shown else {},
        "evaluate_every": config.evaluate_every,
        "splits": [split.as_row(name) for name, split in parts.splits.items()],
        "points": [asdict(point) for point in points],
    }
    (out / "image_policy.json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")
    _draw(out, points, losses, shown, trained)
    write_page(out, points, about)
    shutil.rmtree(out / TRAINING, ignore_errors=True)
    return _facts(about, points)


def _views(inputs: Inputs, parts: Parts, out: Path, stride: int, config: ImagePolicyConfig) -> list[Clip]:
    """Clips of the held-out trajectories in changed looks, rendered unless an interrupted run has done so."""
    chosen = choose_trajectories(parts.held_out, config.shifted_trajectories, config.shifted_first)
    if not chosen:
        return []
    if not (out / VIEWS).exists():
        with within(0.0, RENDERED):
            turn_rad = math.radians(config.viewpoint_deg)
            write_views(inputs, chosen, parts.train, out, seed=config.seed, viewpoint_rad=turn_rad, stride=stride)
    shutil.rmtree(out / FRAMES, ignore_errors=True)  # also where a run was killed before it came to that
    return clips_of(out / VIEWS, chosen)


def _elevations_deg(out: Path) -> dict[str, float]:
    """Turn of the head camera from where the scene has it, by shift of the viewpoint."""
    table = read_table(out / VIEWS / "provenance.parquet")
    turned = {
        shift: json.loads(table["look"][table["appearance"] == place].iloc[0]) for place, shift in enumerate(TITLES)
    }
    return {
        shift: round(math.degrees(look["elevation_offset_rad"]), 6)
        for shift, look in turned.items()
        if shift.startswith("viewpoint")
    }


def _begun_from(training: Path, weights: Path) -> str:
    """Digest of the published weights from which a training begins, or began before it was interrupted.

    Raises:
        BadInput: it began from others.
    """
    path, note = weights / "model.safetensors", training / BEGUN_FROM
    now = _digest(path)
    training.mkdir(exist_ok=True)
    before = note.read_text() if note.exists() else now
    if before != now:
        raise BadInput(
            f"{path}: is not what the interrupted training began from (SHA-256 {now[:16]}..., it was {before[:16]}...); "
            "put that back, or remove what is kept with `sim1 clean` and run again"
        )
    note.with_suffix(".part").write_text(now)
    note.with_suffix(".part").replace(note)
    return now


def _keep(out: Path, trained: Trained, losses: Sequence[float], begun_from: str | None) -> None:
    """Write the policy whole or not at all; before it, from what weights it began."""
    if begun_from:
        (out / BEGUN_FROM).write_text(begun_from)
    pd.DataFrame({"step": np.arange(1, len(losses) + 1), "loss": losses}).to_parquet(
        out / "training.parquet", index=False
    )
    part = out / f"{POLICY}.part"
    shutil.rmtree(part, ignore_errors=True)
    save(part, trained)
    part.rename(out / POLICY)


def _errors(
    out: Path,
    dataset: Path,
    trained: Trained,
    held_out: Sequence[Clip],
    shown: Sequence[Clip],
    stride: int,
    colors: dict[str, np.ndarray],
    chunk_frames: int,
    config: ImagePolicyConfig,
) -> pd.DataFrame:
    """Write `open_loop.parquet`: a row per held-out clip, and per view of those that were rendered anew."""
    how = {
        "chunk_frames": chunk_frames,
        "every": config.evaluate_every,
        "batch": config.batch,
        "workers": config.workers,
        "seed": config.seed,
    }
    looks = {shift: [clip for clip in shown if clip.appearance == place] for place, shift in enumerate(TITLES)}
    with within(0.0, 0.5):
        rows = errors_of(trained, dataset, {DATASET: held_out}, **how)
    with within(0.5, 0.9):
        rows += errors_of(trained, out / VIEWS, looks, stride=stride, **how)
    with within(0.9, 1.0):
        blank = {BLANK: looks[IN_DOMAIN]}
        rows += errors_of(trained, out / VIEWS, blank, stride=stride, see=without_pictures(colors), **how)
    report(1.0, 1.0, "errors measured")
    table = pd.DataFrame(rows, columns=list(ERROR_COLUMNS))
    table.to_parquet(out / "open_loop.parquet", index=False)
    return table


def _draw(out: Path, points: Sequence[Point], losses: Sequence[float], shown: Sequence[Clip], trained: Trained) -> None:
    if points:
        save_figure(draw_errors(points), out / "errors.png", dpi=110)
    if shown:
        save_figure(draw_looks(out / VIEWS, shown, trained.policy.config), out / "looks.png", dpi=110)
    save_figure(draw_loss(losses), out / "loss.png", dpi=110)


def _facts(about: dict[str, Any], points: Sequence[Point]) -> Facts:
    plain = of_pictures(points, DATASET)
    return {
        "policy": f"{about['policy']}, size {about['size']}, on {about['device']}",
        "parameter_count": about["parameter_count"],
        "training_trajectory_count": about["train_count"],
        "held_out_trajectory_count": about["held_out_count"],
        "held_out_joint_error_rad": plain and plain.joint_rad.value,
        "standing_still_joint_error_rad": plain and plain.hold_joint_rad,
        "shifts": [
            {"pictures": p.pictures, "trajectories": p.trajectory_count, "joint_error_rad": p.joint_rad.value}
            for p in points
        ],
        "stand_in": "rendered pictures, simulated cloth, a scripted expert; no robot",
    }


def _trajectory_count(clips: Sequence[Clip]) -> int:
    return len({(clip.trajectory.garment, clip.trajectory.name) for clip in clips})


def _window(losses: Sequence[float]) -> int:
    """Steps at either end whose mean loss is told."""
    return max(1, len(losses) // 10)


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
