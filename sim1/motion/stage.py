"""Stages of the motion room: segment_pool, motion_model, motion_likeness, candidate_trajectories."""

import json
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from sim1.stage import BadInput, Facts, Finding, Inputs, garment_of, only, stage_config


@stage_config
class SegmentPoolConfig:
    """How demonstrations are cut."""

    change_rate_per_s: float = Field(0.25, gt=0)  # openness per second: slower drift is sensor noise, not a grasp
    hold_below: float = Field(0.15, gt=0, le=1)  # openness of a gripper that can hold cloth: 13 mm between the pads
    release_above: float = Field(0.25, gt=0, le=1)  # wider than hold_below, so that a grasp does not flicker
    contact_m: float = Field(0.03, gt=0)  # finger tips to nearest vertex: an edge length and a finger's width
    margin_s: float = Field(0.8, ge=0)  # last approach and first retreat, which depend on the cloth
    minimum_s: float = Field(0.3, ge=0)  # shorter segments belong to their neighbours


@stage_config
class MotionModelConfig:
    """The generator of transitions."""

    seed: int = 0  # initial weights, examples, noise
    method: Literal["diffusion", "minimum_jerk", "straight", "slicing"] = "diffusion"  # the others are baselines
    width: int = Field(64, ge=16, multiple_of=4)  # of the transformer
    layer_count: int = Field(2, ge=1)
    token_count: int = Field(32, ge=8)  # even phases of a transition
    shape_count: int = Field(32, ge=1, le=128)  # principal shapes of the residuals that a sample may be made of
    bank_count: int = Field(3000, ge=32)  # random variations of the demonstrated transitions
    step_count: int = Field(4000, ge=11)  # optimizer steps, about 20 ms each on one core; a tenth of them warms up
    batch_size: int = Field(16, ge=2)
    learning_rate: float = Field(4e-3, gt=0)
    sampling_steps: int = Field(16, ge=2)  # of DDIM


@stage_config
class MotionLikenessConfig:
    """How many paths are planned to be compared with the demonstrations."""

    seed: int = (
        0  # path i draws from its own stream of (seed, garment, i), transition by transition, whatever the method
    )
    path_count: int = Field(24, ge=1)  # by each method, with the garment where the demonstrations found it
    moved_count: int = Field(6, ge=0)  # by each method, with the garment moved
    tries_per_path: int = Field(4, ge=1)  # a draw out of the arms' reach is drawn again
    radius_m: float = Field(0.05, ge=0)  # moved garment: translation within this disc, as in candidate_trajectories
    angle_deg: float = Field(15.0, ge=0)  # moved garment: rotation up to this
    settle_s: float = Field(0.7, ge=0)  # rest at the end
    permutation_count: int = Field(500, ge=20)  # exchanges within families behind the p-value of the mean discrepancy
    split_count: int = Field(10, ge=1)  # random halves of the demonstrations that show what chance looks like


@stage_config
class CandidateTrajectoriesConfig:
    """Algorithm 1: how many attempts, and how much they vary."""

    seed: int = 0  # every attempt draws from its own stream of (seed, garment, series, number)
    candidate_count: int = Field(3, ge=1)  # attempts that run, meant to succeed
    more_of: dict[str, Annotated[int, Field(ge=1)]] = Field(default_factory=dict)  # garment -> so many beyond that
    success_target: int = Field(1, ge=0)  # with fewer successes among them, more are made, as in Algorithm 1 ...
    run_limit: int = Field(6, ge=1)  # ... up to this many that run
    perturbed_count: int = Field(1, ge=0)  # attempts that run with displaced grasps, for the filters to see failures
    tries_per_candidate: int = Field(4, ge=1)  # a draw out of the arms' reach costs no simulation, and is drawn again
    perturbation_m: float = Field(0.04, gt=0)  # a displaced grasp misses or takes hold of the wrong place
    radius_m: float = Field(0.05, ge=0)  # garment placement: translation within this disc
    angle_deg: float = Field(15.0, ge=0)  # garment placement: rotation up to this
    solver: Literal["avbd", "vbd"] = "avbd"  # of the cloth; vbd is newton's own, for the ablation
    settle_s: float = Field(0.7, ge=0)  # rest at the end, so that the judged state is at rest
    video_width: int = Field(64, ge=16)  # px, cheap head view
    video_height: int = Field(48, ge=16)  # px
    video_rate_hz: float = Field(10.0, gt=0, le=30)


def segment_pool(inputs: Inputs, out: Path, config: SegmentPoolConfig) -> Facts:
    """Cut every demonstration into interacting and moving segments (paper, section DataGen)."""
    from sim1.motion.cutting import cut_demos
    from sim1.motion.pool import write_pool

    segments = cut_demos(only(inputs, "seed_demos"), only(inputs, "scene"), garment_of(inputs), config, out)
    write_pool(out, segments)
    kinds = [part.kind for part in segments]
    return {
        "demonstration_count": len({part.demo for part in segments}),
        "interacting_count": kinds.count("interacting"),
        "moving_count": kinds.count("moving"),
    }


def check_segment_pool(artifact: Path) -> list[Finding]:
    """Segments cover every frame once, alternate, and hold a grasp where the arm interacts."""
    from sim1.motion.cutting import pool_findings

    return pool_findings(artifact)


def motion_model(inputs: Inputs, out: Path, config: MotionModelConfig) -> Facts:
    """Fit durations and train the diffusion-forcing transformer on the demonstrated transitions."""
    from sim1.motion.fitting import fit_model

    return fit_model(only(inputs, "segment_pool"), garment_of(inputs), config, out)


def check_motion_model(artifact: Path) -> list[Finding]:
    """The model reads, meets its boundary poses exactly, and knows more of the demonstrations than their mean."""
    from sim1.motion.model import read_model

    read_model(artifact)
    record = json.loads((artifact / "training.json").read_text())
    findings = [
        Finding(
            name="boundary_poses_exact",
            passed=record["boundary_error"] == 0,
            detail=f"largest difference {record['boundary_error']:.1e} between sampled and given boundary poses, limit 0",
        )
    ]
    if record["method"] == "diffusion":
        ratio = record["from_noise_loss"] / record["from_noise_trivial"]
        where = (
            "held-out demonstrations"
            if record["held_out_loss"] is not None
            else "what it trained on, as too few to hold one out"
        )
        findings.append(
            Finding(
                name="learned_something",
                passed=ratio < 0.9,
                detail=f"error from pure noise {ratio:.2f} of that of the better of interpolant and mean residual on {where}, limit 0.9",
            )
        )
        findings.append(
            Finding(
                name="as_smooth_as_demonstrations",
                passed=record["jerk_ratio"] < 5,
                detail=f"median jerk of samples {record['jerk_ratio']:.2f} times the demonstrations', limit 5",
                blocking=False,
            )
        )
    return findings


def motion_likeness(inputs: Inputs, out: Path, config: MotionLikenessConfig) -> Facts:
    """Plan paths without simulation and measure how like the demonstrations' their transitions are."""
    from sim1.motion.likeness.measuring import measure

    return measure(inputs, garment_of(inputs), config, out)


def check_motion_likeness(artifact: Path) -> list[Finding]:
    """Figures are numbers or say why not; limits of likeness are warnings."""
    from sim1.motion.likeness.checking import findings

    return findings(artifact)


def candidate_trajectories(inputs: Inputs, out: Path, config: CandidateTrajectoriesConfig) -> Facts:
    """Assemble, run and judge candidates; every attempt is recorded, whatever came of it (paper, Algorithm 1)."""
    from sim1.motion.generation import generate

    return generate(inputs, garment_of(inputs), config, out)


def check_candidate_trajectories(artifact: Path) -> list[Finding]:
    """Every attempt is accounted for, what ran can be read, and the joints of stored episodes kept to the arm's speed limits."""
    import numpy as np
    import pandas as pd

    from sim1.episode import episode_folders, read_episode
    from sim1.motion.generation import fastest_share

    attempts = pd.read_parquet(artifact / "attempts.parquet")
    limit_rad_s = np.array(json.loads((artifact / "limits.json").read_text())["joint_speed_rad_s"])
    unread, shares = [], {}
    folders = {folder.name: folder for folder in episode_folders(artifact)}
    for name in attempts.loc[attempts.ran, "episode"]:
        try:
            shares[name] = fastest_share(read_episode(folders[name]), limit_rad_s)
        except (BadInput, KeyError) as error:
            unread.append(f"{name}: {error}")
    unexplained = attempts[~attempts.success & attempts.failure.isna()]
    fastest = max(shares, key=shares.__getitem__, default="")
    successes = int(attempts.success.sum())
    return [
        Finding(
            name="episodes_readable",
            passed=not unread and len(folders) == int(attempts.ran.sum()),
            detail="; ".join(unread)
            or f"{len(folders)} episodes of {len(attempts)} attempts, {int(attempts.ran.sum())} ran",
        ),
        Finding(
            name="failures_explained",
            passed=unexplained.empty,
            detail=f"{len(unexplained)} of {len(attempts)} attempts failed without a class, limit 0",
        ),
        Finding(
            name="joint_speeds",
            passed=not fastest or shares[fastest] <= 1 + 1e-6,  # rounding of a step that is as large as it may be
            detail=f"fastest joint, commanded or measured, {shares[fastest]:.2f} times its limit in episode {fastest}, limit 1"
            if fastest
            else "no episode",
        ),
        Finding(
            name="some_success",
            passed=successes > 0,
            detail=f"{successes} of {len(attempts)} attempts succeeded, expected at least 1",
            blocking=False,
        ),
    ]
