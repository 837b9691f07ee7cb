"""Stages `policy`, `scaling_report`, `ablation_report` and `cost_report`."""

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from sim1.stage import Facts, Finding, Inputs, distinct, only, stage_config

type Shift = Literal["in-domain", "spatial", "friction"]
type Factors = Annotated[tuple[Annotated[float, Field(gt=0)], ...], Field(min_length=1)]


@stage_config
class PolicyConfig:
    """Training on generated and on real trajectories, and trials in a simulated cell."""

    seed: int = 0  # of the split, the orders of the trajectories and the placements of the trials
    # Trajectories to train on: of all garments together, at least one each; beyond what there is, all there is.
    sizes: tuple[int, ...] = (2, 4, 8, 16)  # generated
    simulated_sizes: tuple[int, ...] = (4,)  # demonstrations in the simulator, to compare with; empty: none
    real_sizes: tuple[int, ...] = (1, 2, 4)  # demonstrations in what plays reality, likewise
    seeds: Annotated[tuple[int, ...], Field(min_length=1), AfterValidator(distinct)] = (
        0,
        1,
    )  # one model per size and seed, which draws its training set and its first weights
    test_share: float = Field(0.25, gt=0, lt=1)  # of each garment's trajectories, wanted for the open-loop test
    steps: int = Field(1500, gt=0)  # gradient steps per model
    batch: int = Field(128, gt=0)  # frames per step
    learning_rate: float = Field(1e-3, gt=0)  # at the start of a cosine
    input_noise: float = Field(0.05, ge=0)  # standard deviation in units of each input's spread; teaches recovery
    width: int = Field(128, gt=0)  # of the hidden layers
    depth: int = Field(3, gt=0)  # hidden layers
    chunk_s: float = Field(1.0, gt=0)  # commands predicted at once
    replan_s: float = Field(0.1, gt=0)  # a new chunk that often; at least one frame of the dataset
    ensemble_decay: float = Field(0.1, ge=0)  # weight exp(-decay * age in chunks) of older chunks; large: newest alone
    trials_in: Literal["reality", "simulator"] = "reality"  # the stand-in, or the cell that made the training data
    trial_count: int = Field(2, ge=0)  # closed-loop trials per garment, model and shift
    shifts: Annotated[tuple[Shift, ...], AfterValidator(distinct)] = (
        "in-domain",
        "spatial",
    )  # what is other in trials than in the demonstrations
    evaluate_garment_count: int = Field(1, ge=0)  # in the closed loop, which takes longest
    evaluate_first: tuple[str, ...] = ("towel",)  # preferred for it, where the dataset has them; then by name
    evaluate_sizes: int = Field(
        2, ge=1
    )  # training sizes of the closed loop, largest first, then smallest, then between
    evaluate_seeds: int = Field(1, ge=1)  # models per size of the closed loop, in order of `seeds`
    laid_m: float = Field(0.01, ge=0)  # in-domain: laid down by hand at the same place, within this radius
    shift_m: float = Field(0.08, ge=0)  # spatial: moved within this radius (paper, section 4.1: 8 cm)
    turn_rad: float = Field(math.radians(15), ge=0)  # and turned within this angle (paper: 15 degrees)
    friction_factors: Factors = (0.6, 1.6)  # friction: of all contacts, in turn; garment as in-domain
    processes: int = Field(0, ge=0, exclude=True)  # trials at once; 0: one per core; no part of the recipe
    time_factor: float = Field(1.2, gt=0)  # a trial lasts this many times its garment's longest real demonstration


@stage_config
class ScalingReportConfig:
    """Intervals of the curve."""

    seed: int = 0  # of the bootstrap


@stage_config
class AblationReportConfig:
    """Nothing to choose."""


@stage_config
class CostReportConfig:
    """Nothing to choose: prices are a source of their own."""


def policy(inputs: Inputs, out: Path, config: PolicyConfig) -> Facts:
    """Train one state policy per size and seed, measure its held-out error, let it drive a simulated cell.

    Raises:
        BadInput: the dataset is damaged, or has no trajectory to train on.
    """
    from sim1.policy.experiment import run_experiment

    return run_experiment(inputs, out, config)


def check_policy(artifact: Path) -> list[Finding]:
    """Weights are finite, every model and every trial is accounted for, and training did more than nothing."""
    from sim1.policy.checks import check_experiment

    return check_experiment(artifact)


def scaling_report(inputs: Inputs, out: Path, config: ScalingReportConfig) -> Facts:
    """Held-out error and success against the number of training trajectories, and the worth of a real demonstration."""
    from sim1.picture_file import save_figure
    from sim1.policy.counting import read_figures, read_table
    from sim1.policy.curve import Curve, write_curve
    from sim1.policy.equivalence import Worth, worth
    from sim1.policy.experiment import ABOUT_SCHEMA
    from sim1.policy.lessons import GENERATED
    from sim1.policy.scaling import fit_power_laws, measure, measure_over_real, measure_tasks
    from sim1.policy.scaling_page import write_scaling_page
    from sim1.policy.scaling_pictures import draw_error, draw_success
    from sim1.policy.success_law import fit_success
    from sim1.policy.worlds import worlds_of

    source = only(inputs, "policy")
    about = read_figures(source / "policy.json", ABOUT_SCHEMA, "policy")
    open_loop, trials = (read_table(source / name) for name in ("open_loop.parquet", "evaluation.parquet"))
    sizes = {kind: lesson["sizes"] for kind, lesson in about["lessons"].items()}
    points = measure(open_loop, trials, sizes, config.seed)
    fits, success_fits = fit_power_laws(open_loop, config.seed), fit_success(trials, config.seed)
    worths = worth(about["lessons"], open_loop, trials, config.seed)
    if len(open_loop):
        save_figure(draw_error(points, fits), out / "error.png", dpi=110)
    if len(trials):
        save_figure(draw_success(points, success_fits), out / "success.png", dpi=110)
    curve = Curve(
        points=tuple(points),
        fits=tuple(fits),
        success_fits=tuple(success_fits),
        worths=tuple(worths),
        tasks=tuple(measure_tasks(trials)),
        over_real=measure_over_real(trials),
        worlds={world: tuple(garments) for world, garments in worlds_of(trials).items()},
    )
    write_curve(out, curve)
    write_scaling_page(out, about)
    largest = next(point for point in reversed(points) if point.trained_on == GENERATED)
    own = next((error for error in largest.errors if error.tested_on == GENERATED), None)
    known = [one for one in worths if isinstance(one, Worth)]
    return {
        "largest_size": largest.size,
        "held_out_joint_error_rad": own and own.joint_error_rad,
        "standing_still_joint_error_rad": own and own.hold_joint_error_rad,
        "trial_count": len(trials),
        "success_count": int(trials["success"].sum()),
        "worth_of_a_real_demonstration": ", ".join(
            f"{one.bound or ''} {one.ratio:.3g} by {one.figure}" for one in known
        )
        or "not known",
        "stand_in": "simulation plays reality, a scripted expert plays the teleoperator",
    }


def check_scaling_report(artifact: Path) -> list[Finding]:
    """Counts of curve and page agree, intervals hold their values, shifts add up."""
    from sim1.policy.checks import check_curve

    return check_curve(artifact)


def ablation_report(inputs: Inputs, out: Path, config: AblationReportConfig) -> Facts:
    """Pass rate and success rate of the base graph and of every variant (paper, table "Ablation on designs")."""
    from sim1.picture_file import save_figure
    from sim1.policy.ablation import SCHEMA, as_record, count_variant, draw_table, variants_of
    from sim1.policy.ablation_page import write_ablation_page

    rows = [count_variant(inputs, variant) for variant in variants_of(inputs)]
    save_figure(draw_table(rows), out / "ablation.png", dpi=110)
    table = {"schema": SCHEMA, "rows": [as_record(row) for row in rows]}
    (out / "table.json").write_text(json.dumps(table, indent=1, sort_keys=True) + "\n")
    write_ablation_page(out)
    shown = ("variant", "accepted_count", "candidate_count", "success_count", "trial_count")
    return {"variants": [{key: record[key] for key in shown} for record in table["rows"]]}


def check_ablation_report(artifact: Path) -> list[Finding]:
    """Intervals hold their values, counts fit together, and every variant stands on the page with them."""
    from sim1.policy.checks import check_table

    return check_table(artifact)


def cost_report(inputs: Inputs, out: Path, config: CostReportConfig) -> Facts:
    """The paper's cost arithmetic, and this machine's where seconds were measured (source `timings`).

    Raises:
        BadInput: the price file, the timings, decisions or the dataset's provenance are not what they should be.
    """
    from sim1.policy.cost import pace_of, paper_simulation, read_prices, read_timings, real_collection, this_machine
    from sim1.policy.cost_page import SCHEMA, shown, write_cost_page
    from sim1.policy.counting import attempt_counts, shown_count

    prices = read_prices(only(inputs, "prices"))
    timings = read_timings(only(inputs, "timings")) if inputs.get("timings") else {}
    attempted, count = attempt_counts(inputs["valid_trajectories"])
    shown_in_dataset = shown_count(only(inputs, "dataset"))
    pace = pace_of(timings, attempted, count, shown_in_dataset)
    here = this_machine(prices, pace)
    methods = [real_collection(prices), paper_simulation(prices), *([here] if here else [])]
    costs = {
        "schema": SCHEMA,
        "attempted_count": attempted,
        "accepted_count": count,
        "shown_count": shown_in_dataset,
        "methods": [
            {**asdict(item), "usd_per_trajectory": item.usd_per_trajectory, "measured": item is here}
            for item in methods
        ],
        "pace": pace and asdict(pace),
        "seconds": {stage: dict(times) for stage, times in timings.items() if times},
        "not_in_seconds": [stage for stage, times in timings.items() if not times],
    }
    (out / "costs.json").write_text(json.dumps(costs, indent=1, sort_keys=True) + "\n")
    write_cost_page(out, prices, timings)
    return {
        "attempted_count": attempted,
        "accepted_count": count,
        "shown_count": shown_in_dataset,
        "seconds_per_attempt": pace and pace.attempted_s,
        "seconds_per_accepted_trajectory_with_frames": pace and pace.trajectory_s,
        "methods": [shown(item, methods[0]) for item in methods],
    }


def check_source_prices(path: Path) -> None:
    """Raises BadInput where the price file is at fault: before any work, rather than at the end of it."""
    from sim1.policy.cost import read_prices

    read_prices(path)


def check_cost_report(artifact: Path) -> list[Finding]:
    """The page states the unit costs on record, and this machine stands there where its seconds are known, at their pace."""
    from sim1.policy.checks import check_costs

    return check_costs(artifact)
