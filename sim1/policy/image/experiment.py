"""The work of stage `image_policy`: split, render changed pictures, train, test, report."""

import hashlib
import json
import math
import os
import shutil
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
from lerobot.configs import PreTrainedConfig

from sim1.picture_file import save_figure
from sim1.policy.counting import read_table
from sim1.policy.episodes import read_rate_hz
from sim1.policy.image.build import load, policy_config, trained_on
from sim1.policy.image.clips import Clip, Parts, clips_of, split_clips
from sim1.policy.image.exam import Exam
from sim1.policy.image.frames import looks_back, read_features, training_statistics
from sim1.policy.image.measures import DATASET, SCHEMA, Point, measure, of_pictures
from sim1.policy.image.needs import CPU, choose_device, weights_folder
from sim1.policy.image.networks import Course, make_networks, take_policies
from sim1.policy.image.page import write_page
from sim1.policy.image.pictures import draw_errors, draw_looks, draw_loss
from sim1.policy.image.policy_file import find_policy
from sim1.policy.image.shifts import TITLES
from sim1.policy.image.stage import ImagePolicyConfig
from sim1.policy.image.training import TrainingPlan
from sim1.policy.image.views import choose_trajectories, write_views
from sim1.policy.split import sources_of_tests
from sim1.progress import report, within
from sim1.stage import BadInput, Facts, Inputs, only

POLICIES, VIEWS = "policies", "views"  # folders
FRAMES, TRAINING = "frames", "training"  # others, while at work
LOSSES, ERRORS = "training.parquet", "open_loop.parquet"  # there once the policies are
BEGUN_FROM = "weights.sha256"  # file in TRAINING, and beside the policies once they are there
RENDERED = 0.3  # share of the progress that is reached


def run_experiment(inputs: Inputs, out: Path, config: ImagePolicyConfig) -> Facts:
    """Write policies, views, errors, page and pictures into `out`."""
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
    course = Course(
        dataset=dataset,
        episodes=episodes,
        settings=settings,
        weights=weights,
        fresh=fresh,
        statistics=statistics,
        plan=TrainingPlan(
            steps=config.steps,
            batch=config.batch,
            seed=config.seed,
            workers=config.workers,
            checkpoint_s=config.checkpoint_s,
            kept_mib=config.kept_mib,
        ),
        seeds=config.seeds,
        exam=Exam(
            dataset=dataset,
            held_out=parts.held_out,
            views=out / VIEWS,
            shown=shown,
            stride=stride,
            colors={name: statistics[name]["mean"] for name in settings.image_features},
            chunk_frames=chunk_frames,
            every=config.evaluate_every,
            batch=config.batch,
            workers=config.workers,
            seed=config.seed,
        ),
    )
    with within(RENDERED if shown else 0.0, 1.0):
        if not (out / POLICIES).exists():
            _make(course, parts, out, config)
    losses, errors = (read_table(out / name) for name in (LOSSES, ERRORS))
    points = measure(errors, config.seed)
    folders = [out / POLICIES / str(seed) for seed in config.seeds]
    trained = load(folders[0], device)
    about = {
        "schema": SCHEMA,
        "policy": config.policy,
        "title": file.title,
        "type": settings.type,
        "size": config.size,
        "device": " and ".join(sorted({trained_on(folder) for folder in folders})),  # a run may end elsewhere
        "parameter_count": sum(item.numel() for item in trained.policy.parameters()),
        "inputs": sorted(settings.input_features),
        "weights_sha256": (out / BEGUN_FROM).read_text() if weights else None,
        "rate_hz": rate_hz,
        "chunk_frames": chunk_frames,
        "training": {"steps": config.steps, "batch": config.batch},
        "networks": [_network(seed, losses, errors) for seed in config.seeds],
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
    _draw(out, points, losses, shown, settings)
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


def _make(course: Course, parts: Parts, out: Path, config: ImagePolicyConfig) -> None:
    """Write the tables and, once they are there, the policies; before them, from what weights they began."""
    training = out / TRAINING
    training.mkdir(exist_ok=True)
    begun_from = _begun_from(training, course.weights) if course.weights else None
    losses, errors = make_networks(course, training, _processes(course, config.processes))
    losses.to_parquet(out / LOSSES, index=False)
    sources = sources_of_tests(parts.splits)
    names = zip(errors["garment"], errors["trajectory"], strict=True)
    errors.insert(errors.columns.get_loc("trajectory") + 1, "source", [sources[name] for name in names])
    errors.to_parquet(out / ERRORS, index=False)
    if begun_from:
        (out / BEGUN_FROM).write_text(begun_from)
    take_policies(training, course.seeds, out / POLICIES)


def _processes(course: Course, wanted: int) -> int:
    """One where there is a GPU, unless more are wanted: its memory is that of all."""
    usual = 1 if course.settings.device != CPU else os.process_cpu_count() or 1
    return min(wanted or usual, len(course.seeds))


def _network(seed: int, losses: pd.DataFrame, errors: pd.DataFrame) -> dict[str, Any]:
    """How one network's training went, and its mean error on the dataset's held-out trajectories (None: there are none)."""
    own = losses["loss"][losses["seed"] == seed].tolist()
    tried = errors[(errors["seed"] == seed) & (errors["pictures"] == DATASET)]
    per_trajectory = tried.groupby(["garment", "trajectory"])["joint_error_rad"].mean()
    return {
        "seed": seed,
        "loss": {"first": _mean(own[: _window(own)]), "last": _mean(own[-_window(own) :])},
        "joint_error_rad": float(per_trajectory.mean()) if len(per_trajectory) else None,
    }


def _draw(
    out: Path, points: Sequence[Point], losses: pd.DataFrame, shown: Sequence[Clip], settings: PreTrainedConfig
) -> None:
    if points:
        save_figure(draw_errors(points), out / "errors.png", dpi=110)
    if shown:
        save_figure(draw_looks(out / VIEWS, shown, settings), out / "looks.png", dpi=110)
    save_figure(draw_loss(losses), out / "loss.png", dpi=110)


def _facts(about: dict[str, Any], points: Sequence[Point]) -> Facts:
    plain = of_pictures(points, DATASET)
    return {
        "policy": f"{about['policy']}, size {about['size']}, on {about['device']}",
        "parameter_count": about["parameter_count"],
        "network_count": len(about["networks"]),
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
