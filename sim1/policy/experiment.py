"""The work of stage `policy`: split, train at several sizes, test on what was held out, drive a simulated cell."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import product
from pathlib import Path

import pandas as pd

from sim1.picture_file import save_figure
from sim1.policy.episodes import read_keypoints, read_rate_hz
from sim1.policy.lessons import GENERATED, REAL, SIMULATED, Lesson, ModelKey, none_because, read_lessons
from sim1.policy.model import ChunkPolicy, kept_policy, save_policy
from sim1.policy.pictures import draw_command
from sim1.policy.rollout import Driving
from sim1.policy.split import sources_of_tests
from sim1.policy.stage import PolicyConfig
from sim1.policy.time_limit import time_limits
from sim1.policy.training import TrainingPlan, open_loop_error, train
from sim1.policy.trial_crew import Plan, finish, run_trials, tidied
from sim1.policy.trial_strips import draw_trials
from sim1.policy.trials import TRIAL_COLUMNS, TrialSettings
from sim1.progress import report, within
from sim1.stage import BadInput, Facts, Inputs, only

OPEN_LOOP_COLUMNS = (
    "trained_on", "size", "seed", "tested_on", "garment", "trajectory", "source",
    "joint_error_rad", "openness_error", "hold_joint_error_rad",
)  # fmt: skip
ABOUT_SCHEMA = "sim1.policy_result/4"  # of policy.json
TRIALS = "trials"  # folder, while at work
TRAINING_SHARE = 0.2  # of the progress bar; trials in the simulator take the rest


def run_experiment(inputs: Inputs, out: Path, config: PolicyConfig) -> Facts:
    """Write models, `policy.json`, `open_loop.parquet`, `evaluation.parquet`, `facts.json` and pictures into `out`."""
    if facts := tidied(out / TRIALS):
        return facts
    dataset = only(inputs, "dataset")
    demos = {SIMULATED: inputs.get("seed_demos", {}), REAL: inputs.get("real_demos", {})}
    rate_hz = read_rate_hz(dataset)
    known = read_lessons(dataset, demos, config)
    lessons = [lesson for lesson in known if lesson.sizes]
    generated = lessons[0]
    garments = sorted(generated.splits)
    plan = TrainingPlan(
        steps=config.steps,
        batch=config.batch,
        learning_rate=config.learning_rate,
        input_noise=config.input_noise,
        chunk_frames=max(2, round(config.chunk_s * rate_hz)),
        width=config.width,
        depth=config.depth,
    )
    with within(0.0, TRAINING_SHARE):
        models = _train_all(lessons, garments, config.seeds, plan, out / "policies")
    errors = _errors(models, lessons)
    driving = Driving(
        rate_hz=rate_hz,
        replan_frames=min(max(1, round(config.replan_s * rate_hz)), plan.chunk_frames),
        decay=config.ensemble_decay,
    )
    driven = trial_garments(garments, config.evaluate_first, config.evaluate_garment_count)
    limits = time_limits(known, driven, config.time_factor, rate_hz)
    trials = Plan(
        inputs={name: places for name, places in inputs.items() if name != "dataset"},
        models=out / "policies",
        drivers={name: drivers(lessons, name, config) for name in driven},
        keypoints={name: read_keypoints(dataset, name) for name in driven},
        settings=TrialSettings(driving=driving, limits=limits, config=config),
    )
    with within(TRAINING_SHARE, 1.0):
        rows, strips = run_trials(trials, out / TRIALS, config.processes)
        report(1.0, 1.0, "trials done")

    pd.DataFrame(errors, columns=list(OPEN_LOOP_COLUMNS)).to_parquet(out / "open_loop.parquet", index=False)
    pd.DataFrame(rows, columns=list(TRIAL_COLUMNS)).to_parquet(out / "evaluation.parquet", index=False)
    about = {
        "schema": ABOUT_SCHEMA,
        "rate_hz": rate_hz,
        "seeds": list(config.seeds),
        "lessons": {lesson.kind: _told(lesson, config) for lesson in lessons},
        "no_real_demonstrations": None
        if any(lesson.kind == REAL for lesson in lessons)
        else none_because(demos[REAL], config.real_sizes),
        "training": asdict(plan),
        "driving": asdict(driving),
        "trials": {
            "worlds": sorted({row["world"] for row in rows}),
            "garments": driven,
            "models": {name: [list(key) for key in keys] for name, keys in trials.drivers.items()},
            "shifts": list(config.shifts),
            "each": config.trial_count,
            "time_factor": config.time_factor,
            "time_limits": {name: asdict(limit) for name, limit in limits.items()},
            "laid_m": config.laid_m,
            "shift_m": config.shift_m,
            "turn_rad": config.turn_rad,
            "friction_factors": list(config.friction_factors),
        },
    }
    (out / "policy.json").write_text(json.dumps(about, indent=1, sort_keys=True) + "\n")
    model = models[ModelKey(GENERATED, generated.sizes[-1], config.seeds[0])]
    shown = (generated.held_out or generated.orders[config.seeds[0]])[0]
    save_figure(draw_command(model, shown, held_out=bool(generated.held_out)), out / "command.png", dpi=110)
    for shift, figure in draw_trials(rows, strips).items():
        save_figure(figure, out / f"trials_{shift}.png", dpi=110)
    largest = [row for row in errors if row["size"] == generated.sizes[-1] and _own(row)]
    facts = {
        "model_count": len(models),
        **{f"{lesson.kind}_sizes": ", ".join(map(str, lesson.sizes)) for lesson in lessons},
        "held_out_trajectory_count": sum(len(lesson.held_out) for lesson in lessons),
        "held_out_joint_error_rad": _mean([row["joint_error_rad"] for row in largest]),
        "standing_still_joint_error_rad": _mean([row["hold_joint_error_rad"] for row in largest]),
        "trial_garments": ", ".join(driven),
        "trials_in": ", ".join(about["trials"]["worlds"]) or "none",
        "trial_count": len(rows),
        "success_count": sum(row["success"] for row in rows),
    }
    return finish(out / TRIALS, facts)


def trial_models(lesson: Lesson, config: PolicyConfig) -> list[ModelKey]:
    """The models that drive: the largest size, the smallest, then those between from above."""
    sizes = lesson.sizes
    ends = list(dict.fromkeys([sizes[-1], sizes[0], *reversed(sizes)]))[: config.evaluate_sizes]
    seeds = config.seeds[: config.evaluate_seeds]
    return [ModelKey(lesson.kind, size, seed) for size, seed in product(sorted(ends), seeds)]


def drivers(lessons: Sequence[Lesson], garment: str, config: PolicyConfig) -> tuple[ModelKey, ...]:
    """The models that drive with a garment: those of lessons that show it."""
    return tuple(key for lesson in lessons if garment in lesson.splits for key in trial_models(lesson, config))


def trial_garments(garments: Sequence[str], first: Sequence[str], count: int) -> list[str]:
    """Garments of the closed loop, at most `count`: the preferred ones that the dataset has, then the others by name."""
    preferred = [name for name in first if name in garments]
    return [*preferred, *sorted(set(garments) - set(preferred))][:count]


def _train_all(
    lessons: Sequence[Lesson], garments: Sequence[str], seeds: Sequence[int], plan: TrainingPlan, folder: Path
) -> dict[ModelKey, ChunkPolicy]:
    """All models, each saved in `folder` once it is trained; one that a killed run saved there is not trained again."""
    folder.mkdir(exist_ok=True)
    tasks = [(lesson, size, seed) for lesson in lessons for size in lesson.sizes for seed in seeds]
    models = {}
    for done, (lesson, size, seed) in enumerate(tasks):
        what = f"training on {size} {lesson.kind} trajectories, seed {seed}"
        report(done, len(tasks), what)
        key, shown = ModelKey(lesson.kind, size, seed), lesson.training_set(size, seed)
        names = [f"{item.garment}/{item.name}" for item in shown]
        learnt = json.dumps({**asdict(plan), "seed": seed, "garments": garments, "from": names}, sort_keys=True)
        if (model := kept_policy(folder / key.file, learnt)) is None:
            model = train(shown, garments, plan, seed)
            if not model.is_finite():
                raise BadInput(
                    f"stage policy: {what}: its weights are not finite after {plan.steps} steps; "
                    f"set a smaller learning_rate than {plan.learning_rate:g} in the profile"
                )
            save_policy(folder / key.file, model, learnt)
        models[key] = model
    return models


def _errors(models: Mapping[ModelKey, ChunkPolicy], lessons: Sequence[Lesson]) -> list[dict[str, object]]:
    """Of every model on its own kind's held-out trajectories, and on the real ones: they are what counts."""
    sources = {lesson.kind: sources_of_tests(lesson.splits) for lesson in lessons}
    return [
        {
            **key._asdict(),
            "tested_on": lesson.kind,
            "garment": item.garment,
            "trajectory": item.name,
            "source": sources[lesson.kind][item.garment, item.name],
            **asdict(open_loop_error(model, item)),
        }
        for key, model in models.items()
        for lesson in lessons
        if lesson.kind in (key.trained_on, REAL)
        for item in lesson.held_out
    ]


def _own(row: Mapping[str, object]) -> bool:
    return row["trained_on"] == row["tested_on"] == GENERATED


def _told(lesson: Lesson, config: PolicyConfig) -> dict[str, object]:
    wanted = {GENERATED: config.sizes, SIMULATED: config.simulated_sizes, REAL: config.real_sizes}
    return {
        "available_count": len(lesson.train),
        "held_out_count": len(lesson.held_out),
        "sizes": lesson.sizes,
        "requested_sizes": list(wanted[lesson.kind]),
        "splits": [split.as_row(name) for name, split in lesson.splits.items()],
        "training_sets": {
            str(size): {
                str(seed): [f"{item.garment}/{item.name}" for item in lesson.training_set(size, seed)]
                for seed in config.seeds
            }
            for size in lesson.sizes
        },
    }


def _mean(values: Sequence[float]) -> float | None:
    return sum(values) / len(values) if values else None
