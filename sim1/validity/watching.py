"""The work of stage video_discriminator: clips, training, honest figures, and the files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from sim1.cloth.garment import GarmentMesh
from sim1.network_file import load_weights, read_network, write_network
from sim1.scene.description import Scene
from sim1.stage import BadInput, Facts, random_stream
from sim1.statistics import describe_share
from sim1.validity.clips import Clip, head_clip, read_clip, sampled
from sim1.validity.discriminator import VideoDiscriminator
from sim1.validity.evidence import doubt, figures, outcome, threshold_for
from sim1.validity.examples import Example, read_examples
from sim1.validity.parts import LabelledClip, split_by_source
from sim1.validity.pictures import draw_scores
from sim1.validity.scoring import scores, train_discriminator

if TYPE_CHECKING:
    from sim1.validity.stage import VideoDiscriminatorConfig

SCHEMA = "sim1.video-discriminator/2"
PARTS = ("train", "calibration", "test")
LOOKS_AT = ("frame_count", "frame_width", "frame_height")  # of a clip: how many frames, and their size in px
RATE_HZ = 10.0  # of the demonstrations' clips, before frames are picked


@dataclass(frozen=True, kw_only=True)
class Discriminator:
    """A trained discriminator with its threshold, or one that abstains and says why."""

    network: VideoDiscriminator | None  # None when a class was missing altogether
    abstains: bool
    reason: str  # why it abstains, or empty
    threshold: float
    frame_count: int
    frame_width: int  # px, of the clips on which it was trained: what it learned is of things of that size
    frame_height: int

    def score(self, clip: Clip, name: str) -> float | None:
        """Probability of being valid of the clip called `name`; None without a network.

        Raises:
            BadInput: the clip's frames have another size.
        """
        if self.network is None:
            return None
        _require_size(clip, self.frame_width, self.frame_height, name)
        return float(scores(self.network, [sampled(clip.frames, self.frame_count)])[0])


def watch(
    demos: Path, candidates: Path, mesh: GarmentMesh, scene: Scene, garment: str, config: VideoDiscriminatorConfig, out: Path
) -> Facts:  # fmt: skip
    """Train, choose a threshold on clips of other demonstrations, test it on those of others again, decide whether it may decide.

    Raises:
        BadInput: an episode or video is damaged, or has frames of another size than `config`.
    """
    torch.set_num_threads(1)
    rng = random_stream(config.seed, garment, "video_discriminator")
    clips = labelled_clips(demos, candidates, mesh, scene, config)
    good = sum(clip.success for clip in clips)
    counts = {"success_count": good, "failure_count": len(clips) - good}
    looks_at = {name: getattr(config, name) for name in LOOKS_AT}
    if min(good, len(clips) - good) == 0:
        reason = f"one class is missing: {good} successes and {len(clips) - good} failures, nothing to tell apart"
        model = Discriminator(network=None, abstains=True, reason=reason, threshold=0.5, **looks_at)
        return _written(
            model,
            {"clips": counts, "calibration": {}, "test": {}, "left_out": _composition([]), "scores": []},
            [],
            config,
            out,
        )
    parts = split_by_source(clips)
    network, losses = train_discriminator(parts.train, config, rng)
    part_of = {clip.name: part for part in PARTS for clip in getattr(parts, part)}
    found = scores(network, [clip.frames for clip in clips])
    rows = [
        {"clip": clip.name, "score": float(value), "success": clip.success, "part": part_of.get(clip.name)}
        for clip, value in zip(clips, found, strict=True)
    ]
    calibration = scored(rows, "calibration")
    threshold = threshold_for(*calibration, config.precision)
    reason = _why_abstain(counts, rows, threshold, len(parts.left_out), config)
    model = Discriminator(
        network=network,
        abstains=bool(reason),
        reason=reason,
        threshold=0.5 if threshold is None else threshold,
        **looks_at,
    )
    metrics = {
        "clips": counts,
        "train": _composition(parts.train),
        "calibration": figures(*calibration, threshold),
        "test": figures(*scored(rows, "test"), threshold),
        "left_out": _composition(parts.left_out),
        "demonstrations": {
            part: sorted(set().union(*(clip.sources for clip in getattr(parts, part)))) for part in PARTS
        },
        "losses": [round(loss, 5) for loss in losses],
        "scores": rows,
    }
    return _written(model, metrics, rows, config, out)


def labelled_clips(
    demos: Path, candidates: Path, mesh: GarmentMesh, scene: Scene, config: VideoDiscriminatorConfig
) -> list[LabelledClip]:
    """Clips of all demonstrations and candidates, as the network sees them.

    Raises:
        BadInput: an episode or video is damaged, or has frames of another size than `config`.
    """
    return [_labelled(item, mesh, scene, config) for item in read_examples(demos, candidates, "clips")]


def scored(rows: list[dict[str, Any]], part: str) -> tuple[np.ndarray, np.ndarray]:
    """Score (n,) and success (n,) of the clips of a part, from `scores` of `metrics.json`."""
    here = [row for row in rows if row["part"] == part]
    return np.array([row["score"] for row in here], float), np.array([row["success"] for row in here], bool)


def _composition(clips: list[LabelledClip]) -> dict[str, int]:
    return {"success_count": sum(clip.success for clip in clips), "clip_count": len(clips)}


def _why_abstain(
    counts: dict[str, int],
    rows: list[dict[str, Any]],
    threshold: float | None,
    left_out: int,
    config: VideoDiscriminatorConfig,
) -> str:
    if min(counts.values()) < config.minimum_per_class:
        return f"too few clips: {counts['success_count']} successes and {counts['failure_count']} failures, " + (
            f"at least {config.minimum_per_class} of each are needed"
        )
    score, success = scored(rows, "calibration")
    mixed = f"; {left_out} mix demonstrations of different parts and are left out" if left_out else ""
    if not len(score):
        return f"no clips could be held out to set a threshold on: training would lack an outcome or a demonstration{mixed}"
    rarer = int(min(success.sum(), (~success).sum()))
    if rarer < config.minimum_held_out:
        return (
            f"too few clips to set a threshold on: {len(score)}, {rarer} of the rarer outcome, "
            f"{config.minimum_held_out} are needed{mixed}"
        )
    if threshold is None:
        return f"no threshold reaches the wanted precision {config.precision:.2f} on {len(score)} calibration clips"
    why = doubt(outcome(*scored(rows, "test"), threshold), config.precision, config.minimum_held_out)
    return f"{why}{mixed}" if why else ""


def _labelled(item: Example, mesh: GarmentMesh, scene: Scene, config: VideoDiscriminatorConfig) -> LabelledClip:
    """A candidate's own video, or a demonstration drawn like it."""
    width, height = config.frame_width, config.frame_height
    if (item.folder / "video.npz").exists():
        clip = read_clip(item.folder)
        _require_size(clip, width, height, str(item.folder))
    else:
        clip = head_clip(item.episode.garment_m, mesh.faces, scene, rate_hz=RATE_HZ, width=width, height=height)
    frames = sampled(clip.frames, config.frame_count)
    return LabelledClip(name=item.name, frames=frames, success=item.success, sources=item.sources)


def _require_size(clip: Clip, width: int, height: int, name: str) -> None:
    """Raises BadInput where a clip is not as large as the discriminator wants it."""
    own_height, own_width = clip.frames.shape[1:3]
    if (own_width, own_height) != (width, height):
        raise BadInput(
            f"{name}: the video has frames of {own_width} x {own_height} px, the discriminator is for {width} x {height}; give "
            "frame_width and frame_height of video_discriminator the values of video_width and video_height of candidate_trajectories"
        )


def _written(model: Discriminator, metrics: dict[str, Any], rows: list[dict[str, Any]], config: VideoDiscriminatorConfig, out: Path) -> Facts:  # fmt: skip
    about = {
        "schema": SCHEMA, "abstains": model.abstains, "reason": model.reason, "threshold": model.threshold,
        "trained": model.network is not None, "width": config.width, "layer_count": config.layer_count,
        **{name: getattr(model, name) for name in LOOKS_AT},
    }  # fmt: skip
    write_network(out, model.network, about)
    metrics = metrics | {"wanted_precision": config.precision, "minimum_held_out": config.minimum_held_out}
    metrics |= {"abstains": model.abstains, "reason": model.reason}
    (out / "metrics.json").write_text(json.dumps(metrics, indent=1, sort_keys=True) + "\n")
    draw_scores(out / "scores.png", rows, model.threshold, model.reason)
    test = metrics["test"]
    facts = {"clips": describe_share(metrics["clips"]["success_count"], sum(metrics["clips"].values())) + " successful"}
    return facts | {
        "calibration_clips": _count(metrics["calibration"]),
        "test_clips": _count(test),
        "left_out_clips": metrics["left_out"]["clip_count"],
        "test_roc_area": test.get("roc_area", "not measured"),
        "abstains": model.abstains,
        "reason": model.reason or "it decides",
    }


def _count(found: dict[str, Any]) -> int:
    return found.get("success_count", 0) + found.get("failure_count", 0)


def read_discriminator(folder: Path) -> Discriminator:
    """Read what the stage wrote.

    Raises:
        BadInput: a file is missing, damaged, or of another schema.
    """

    def build(about: dict[str, Any], weights: Path) -> Discriminator:
        network = None
        if about["trained"]:
            network = load_weights(VideoDiscriminator(about["width"], about["layer_count"]), weights)
        fields = {name: about[name] for name in ("abstains", "reason", "threshold", *LOOKS_AT)}
        return Discriminator(network=network, **fields)

    return read_network(folder, SCHEMA, "video_discriminator", build)
