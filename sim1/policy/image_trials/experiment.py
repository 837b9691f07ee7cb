"""The work of stage `image_trials`: drive, count, show."""

import functools
import json
import shutil
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from sim1.picture_file import save_figure
from sim1.policy.counting import read_figures
from sim1.policy.episodes import read_rate_hz, read_trajectories
from sim1.policy.experiment import trial_garments
from sim1.policy.image.clips import clips_of
from sim1.policy.image.experiment import POLICIES
from sim1.policy.image.measures import SCHEMA as POLICY_SCHEMA
from sim1.policy.image.needs import CPU, GPU, gpu_memory_gib
from sim1.policy.image_trials.crew import COLUMNS, Driver, Plan
from sim1.policy.image_trials.looks import Wardrobe
from sim1.policy.image_trials.measures import SCHEMA, ShiftTried, by_shift, measure
from sim1.policy.image_trials.page import write_page
from sim1.policy.image_trials.pictures import draw_success
from sim1.policy.image_trials.stage import ImageTrialsConfig
from sim1.policy.lessons import GENERATED, REAL, SIMULATED, ModelKey, read_lessons
from sim1.policy.rollout import Driving
from sim1.policy.stage import PolicyConfig
from sim1.policy.time_limit import TimeLimit, time_limits
from sim1.policy.trial_crew import finish, make_trials, tidied
from sim1.policy.trial_strips import draw_trials
from sim1.policy.trials import TrialSettings
from sim1.progress import report
from sim1.render.blender import BlenderFailed
from sim1.stage import BadInput, Facts, Inputs, only

TRIALS, FILES = "trials", "live"  # folders, while at work


def run_experiment(inputs: Inputs, out: Path, config: ImageTrialsConfig) -> Facts:
    """Write `trials.parquet`, `image_trials.json`, `facts.json`, page and pictures into `out`."""
    report(0.0, 1.0, "reading the policy")
    if facts := tidied(out / TRIALS):
        return facts
    learnt = read_figures(only(inputs, "image_policy") / "image_policy.json", POLICY_SCHEMA, "image_policy")
    shutil.rmtree(out / FILES, ignore_errors=True)  # of a killed run's cameras
    (out / FILES).mkdir()
    plan = plan_trials(inputs, learnt, out / FILES, config)
    make = functools.partial(Driver.of, plan)
    rows, strips = make_trials(plan.trials, make, out / TRIALS, plan.processes, (BadInput, BlenderFailed))
    report(1.0, 1.0, "trials done")

    trials = pd.DataFrame(rows, columns=list(COLUMNS))
    trials.to_parquet(out / "trials.parquet", index=False)
    tried = measure(trials)
    about = {
        "schema": SCHEMA,
        **{key: learnt[key] for key in ("policy", "title", "type", "size", "train_count", "rate_hz", "chunk_frames")},
        "device": plan.device,
        "steps": learnt["training"]["steps"],
        "network_seeds": [model.seed for model in plan.models],
        "worlds": sorted({row["world"] for row in rows}),
        "garments": list(plan.wardrobes),
        "shifts": list(config.shifts),
        "each": config.trial_count,
        "driving": asdict(plan.settings.driving),
        "time_factor": config.time_factor,
        "time_limits": {name: asdict(limit) for name, limit in plan.settings.limits.items()},
        "pictures": {name: _pictures(wardrobe) for name, wardrobe in plan.wardrobes.items()},
        **{key: getattr(config, key) for key in ("laid_m", "shift_m", "turn_rad", "viewpoint_deg")},
        "friction_factors": list(config.friction_factors),
        "tried": [asdict(one) for one in tried],
    }
    (out / "image_trials.json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")
    if tried:
        save_figure(draw_success(by_shift(tried)), out / "success.png", dpi=110)
    for shift, figure in draw_trials(rows, strips).items():
        save_figure(figure, out / f"trials_{shift}.png", dpi=110)
    write_page(out, tried, about)
    shutil.rmtree(out / FILES, ignore_errors=True)
    return finish(out / TRIALS, _facts(about, tried))


def plan_trials(inputs: Inputs, learnt: Mapping[str, Any], files: Path, config: ImageTrialsConfig) -> Plan:
    """Who drives what, and how. `learnt`: contents of `image_policy.json`.

    Raises:
        BadInput: an input is missing or damaged, or there is no GPU where one is asked for.
    """
    dataset = only(inputs, "dataset")
    rate_hz = read_rate_hz(dataset)
    held_out = set(learnt["held_out"])
    train = [
        clip
        for clip in clips_of(dataset, read_trajectories(dataset))
        if f"{clip.trajectory.garment}/{clip.trajectory.name}" not in held_out
    ]
    garments = sorted({clip.trajectory.garment for clip in train})
    driven = trial_garments(garments, config.evaluate_first, config.evaluate_garment_count)
    wardrobes = {}
    for name in driven:
        if name not in inputs.get("rendered_episodes", {}):
            raise BadInput(f"stage input 'rendered_episodes': none for garment {name!r}; materialize it first")
        own = [clip for clip in train if clip.trajectory.garment == name]
        wardrobes[name] = Wardrobe.of(inputs["rendered_episodes"][name], own)
    driving = Driving(
        rate_hz=rate_hz,
        replan_frames=min(max(1, round(config.replan_s * rate_hz)), learnt["chunk_frames"]),
        decay=config.ensemble_decay,
    )
    limits = _limits(inputs, driven, config.time_factor, rate_hz)
    return Plan(
        inputs={name: places for name, places in inputs.items() if name != "dataset"},
        policies=only(inputs, "image_policy") / POLICIES,
        device=_device(config.device),
        chunk_frames=learnt["chunk_frames"],
        models=tuple(
            ModelKey(trained_on=GENERATED, size=learnt["train_count"], seed=network["seed"])
            for network in learnt["networks"]
        ),
        wardrobes=wardrobes,
        settings=TrialSettings(driving=driving, limits=limits, config=config),
        config=config,
        files=files,
    )


def _limits(inputs: Inputs, garments: list[str], factor: float, rate_hz: int) -> dict[str, TimeLimit]:
    """Those of stage `policy`: which trajectories train or are held out there makes no difference to the longest one."""
    demos = {SIMULATED: inputs.get("seed_demos", {}), REAL: inputs.get("real_demos", {})}
    return time_limits(read_lessons(only(inputs, "dataset"), demos, PolicyConfig()), garments, factor, rate_hz)


def _device(wanted: str) -> str:
    found = wanted != "cpu" and gpu_memory_gib() > 0
    if wanted == "gpu" and not found:
        raise BadInput("setting device of stage image_trials is gpu, and torch finds none; set it to auto or cpu")
    return GPU if found else CPU


def _pictures(wardrobe: Wardrobe) -> dict[str, Any]:
    """How they are rendered."""
    config = wardrobe.config
    shown = {key: getattr(config, key) for key in ("engine", "width", "height", "samples", "denoise")}
    return {**shown, "cameras": list(config.cameras), "trained_looks": wardrobe.look_count}


def _facts(about: Mapping[str, Any], tried: list[ShiftTried]) -> Facts:
    shown = by_shift(tried)
    return {
        "policy": f"{about['policy']}, size {about['size']}, {about['steps']} steps, on {about['device']}",
        "network_count": len(about["network_seeds"]),
        "training_trajectory_count": about["train_count"],
        "trial_garments": ", ".join(about["garments"]),
        "trials_in": ", ".join(about["worlds"]) or "none",
        "trial_count": sum(one.trial_count for one in shown),
        "success_count": sum(one.success_count for one in shown),
        "shifts": [{"shift": one.shift, "trials": one.trial_count, "successes": one.success_count} for one in shown],
        "stand_in": "rendered pictures, simulated cloth, a scripted expert; no robot",
    }
