"""Diagnose the cloth's recordings: calibrated physics, what the baseline leaves out, and a report of where, when and why."""

from pathlib import Path
from typing import Annotated, Literal

import pydantic

from sim1.stage import BadInput, Facts, Finding, Inputs, only, stage_config


@stage_config
class CalibratedPhysicsConfig:
    """What a diagnosis works with follows from the bundle, its thresholds are those of `sim1 diagnose`."""

    simulate_with: Literal["model", "baseline", "prior"] = (
        "model"  # in the cell: all that was found and it can act, ...
    )
    # ... the calibrated baseline without what was named, or what was known before any recording: for comparison
    # After which the search ends, and what is known by then is the artifact; None: as long as it takes.
    budget_minutes: Annotated[float, pydantic.Field(ge=0.5)] | None = None


def calibrated_physics(inputs: Inputs, out: Path, config: CalibratedPhysicsConfig) -> Facts:
    """Calibrate the baseline to the recordings and find what it leaves out (`sim1 diagnose` on the artifact's bundle).

    Writes `model.yaml` (all that was found), `baseline.yaml`, `cell.yaml` (what the simulated cell contains of the model),
    `verdict.json`, `summary.json` and pictures.

    Raises:
        BadInput: the bundle is damaged or cannot support a diagnosis.
        NotConverged: a recording that the baseline cannot follow.
    """
    from sim1.mismatch.calibrated import write_calibrated

    budget_s = None if config.budget_minutes is None else 60 * config.budget_minutes
    return write_calibrated(only(inputs, "recordings") / "bundle", out, config.simulate_with, budget_s)


def check_calibrated_physics(artifact: Path) -> list[Finding]:
    """The models read, the search converged, the model transfers to motion that it has not seen, the cell contains all of it."""
    from sim1.cloth.cell_physics import cell_physics, effects_left_out
    from sim1.cloth.physics import read_physics
    from sim1.mismatch.summary import read_summary
    from sim1.mismatch.verdict import in_mm, read_verdict

    try:
        models = {name: read_physics(artifact / f"{name}.yaml") for name in ("model", "baseline", "prior")}
        model, baseline, cell = models["model"], models["baseline"], read_physics(artifact / "cell.yaml")
        simulated = [name for name, physics in models.items() if cell == cell_physics(physics)]
        left_out = effects_left_out(model, cell)
        verdict, summary = read_verdict(artifact / "verdict.json"), read_summary(artifact / "summary.json")
    except BadInput as error:
        return [Finding(name="model_reads", passed=False, detail=str(error))]
    error = verdict.rmse_m.augmented
    known = error.heldout is not None and error.fit is not None
    return [
        Finding(
            name="model_reads",
            passed=bool(simulated) and not baseline.effects,
            detail=f"cell.yaml is of {' and '.join(simulated) or 'none of the models'}; {len(model.effects)} effects beyond the baseline, {len(cell.effects)} in cell.yaml, {len(baseline.effects)} in baseline.yaml",
        ),
        Finding(
            name="search_converged",
            passed=summary.converged,
            detail="a search that stops early looks like missing physics",
            blocking=False,
        ),
        Finding(
            name="motion_explained",
            passed=summary.misfit.chosen <= summary.misfit.limit,
            detail=f"mean squared residual {summary.misfit.chosen:.2f} in units of noise and mesh error (limit {summary.misfit.limit})",
            blocking=False,
        ),
        Finding(
            name="heldout_transfers",
            passed=known and error.heldout <= 2.0 * error.fit,
            detail=f"{in_mm(error.heldout)} on held-out motion, {in_mm(error.fit)} on fitted motion (limit twice that)",
            blocking=False,
        ),
        Finding(
            name="heldout_sane",
            passed=error.heldout is not None and error.heldout < 0.05,
            detail=f"{in_mm(error.heldout)} on held-out motion (limit 50 mm)",
        ),
        Finding(
            name="cell_acts_effects",
            passed=not left_out,
            detail=f"found and not simulated in the cell: {', '.join(left_out)}; its cloth goes by cell.yaml, without them"
            if left_out
            else "the simulated cell contains every effect of the cloth that was found",
            blocking=False,
        ),
    ]


@stage_config
class MismatchReportConfig:
    """Nothing to choose: the report says what the diagnosis found."""


def mismatch_report(inputs: Inputs, out: Path, config: MismatchReportConfig) -> Facts:
    """Write `verdict.json` and `report.html` of the diagnosis that `calibrated_physics` made.

    Raises:
        BadInput: an artifact is damaged.
    """
    from sim1.mismatch.report import write_report

    return write_report(only(inputs, "recordings"), only(inputs, "calibrated_physics"), out)


def check_mismatch_report(artifact: Path) -> list[Finding]:
    """The verdict keeps its schema; a difference that no model explains is worth a warning."""
    from sim1.mismatch.verdict import in_mm, read_verdict

    try:
        verdict = read_verdict(artifact / "verdict.json")
    except BadInput as error:
        return [Finding(name="verdict_schema", passed=False, detail=str(error))]
    page = artifact / "report.html"
    size = page.stat().st_size if page.exists() else 0
    error = verdict.rmse_m.augmented.heldout
    return [
        Finding(name="verdict_schema", passed=True, detail=f"verdict {verdict.verdict}, schema {verdict.schema_}"),
        Finding(name="report_written", passed=size > 1000, detail=f"report.html has {size} bytes"),
        Finding(
            name="mismatch_modelled",
            passed=verdict.verdict in ("none", "named"),
            detail=f"verdict {verdict.verdict}: {in_mm(error)} on held-out motion with noise {1e3 * verdict.noise_std_m:.2f} mm",
            blocking=False,
        ),
    ]
