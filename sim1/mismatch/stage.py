"""Calibrate the cloth against its recordings, and say where and why simulation and recording differ."""

from pathlib import Path

from sim1.stage import BadInput, Facts, Finding, Inputs, only, stage_config


@stage_config
class CalibratedPhysicsConfig:
    """How accurately and how long a calibration searches."""

    step_s: float = 1 / 60  # of the search; the correction runs use half of it on a mesh of a quarter of the face size
    passes: int = 2  # the coarse mesh's error is measured anew in each
    iterations: int = 7  # of least squares in a pass; each costs a simulation per unknown and recording
    tolerance: float = 2e-3  # relative change of the cost that ends a pass
    heldout: int = 1  # recordings at the end of the bundle that no fit sees
    accept_gain: float = 0.1  # half the squared error over its variance that an effect must save per held-out sample
    accept_closed: float = 0.5  # share of the excess over noise and mesh error that it must close on held-out motion
    try_air_drag: bool = True  # the one effect in this version's library


def calibrated_physics(inputs: Inputs, out: Path, config: CalibratedPhysicsConfig) -> Facts:
    """Fit the baseline, then with air drag; keep the drag only where motion that nobody fitted says so.

    Writes `model.yaml`, `baseline.yaml`, `fit.json`, `predictions.npz` (markers of both, per recording) and pictures.

    Raises:
        BadInput: the bundle cannot be calibrated by this version, or holds too few recordings.
    """
    from sim1.mismatch.campaign import run_campaign

    return run_campaign(only(inputs, "recordings") / "bundle", out, config)


def check_calibrated_physics(artifact: Path) -> list[Finding]:
    """The model reads, the search converged, the fit transfers to motion that it has not seen."""
    import json

    from sim1.cloth.physics import read_physics

    try:
        models = [read_physics(artifact / name) for name in ("model.yaml", "baseline.yaml")]
        fit = json.loads((artifact / "fit.json").read_text())
        chosen = fit["augmented"] if fit["accepted"] else fit["baseline"]
        floor = chosen["floor_heldout_m"]
        ratio = chosen["rmse_heldout_m"] / floor
    except (BadInput, OSError, KeyError, ValueError) as error:
        return [Finding(name="model_reads", passed=False, detail=str(error))]
    return [
        Finding(name="model_reads", passed=True, detail=f"{len(models[0].effects)} effects beyond the baseline"),
        Finding(
            name="search_converged",
            passed=chosen["converged"],
            detail=f"{chosen['evaluations']} simulations; a search that stops early looks like missing physics",
            blocking=False,
        ),
        Finding(
            name="heldout_explained",
            passed=ratio <= 1.5,
            detail=f"held-out error {1e3 * chosen['rmse_heldout_m']:.2f} mm is {ratio:.2f} times noise and mesh error (limit 1.5)",
            blocking=False,
        ),
        Finding(
            name="heldout_sane",
            passed=chosen["rmse_heldout_m"] < 0.05,
            detail=f"held-out error {1e3 * chosen['rmse_heldout_m']:.2f} mm (limit 50 mm)",
        ),
    ]


@stage_config
class MismatchReportConfig:
    """When a difference counts as one."""

    none_ratio: float = (
        1.1  # held-out error up to this multiple of noise and mesh error is no mismatch; not yet calibrated on nulls
    )


def mismatch_report(inputs: Inputs, out: Path, config: MismatchReportConfig) -> Facts:
    """Locate the difference, name it where that can be done, and write `verdict.json`, `report.html` and pictures."""
    from sim1.mismatch.report import write_report

    return write_report(only(inputs, "recordings"), only(inputs, "calibrated_physics"), out, config)


def check_mismatch_report(artifact: Path) -> list[Finding]:
    """The verdict keeps its schema; a difference that no model explains is worth a warning."""
    from sim1.mismatch.verdict import read_verdict

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
            detail=f"verdict {verdict.verdict}: held-out error {1e3 * error:.2f} mm with noise {1e3 * verdict.noise_std_m:.2f} mm",
            blocking=False,
        ),
    ]
