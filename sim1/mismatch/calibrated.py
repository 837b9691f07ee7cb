"""The artifact of `calibrated_physics`: a diagnosis as models for simulations and as what its report is put together from."""

from pathlib import Path

from sim1.cloth.cell_physics import cell_physics, effects_left_out
from sim1.cloth.physics import nominal_from_priors, write_physics
from sim1.mismatch.diagnose import diagnose
from sim1.mismatch.findings import draw_pictures, summary_of, verdict_of
from sim1.mismatch.model_file import physics_of
from sim1.mismatch.patience import Patience
from sim1.mismatch.strict_json import write_json
from sim1.mismatch.verdict import in_mm
from sim1.progress import report
from sim1.recording.bundle import read_bundle
from sim1.recording.examination import cannot_tell
from sim1.recording.sufficient import require_for_diagnosis
from sim1.stage import Facts


def write_calibrated(bundle: Path, out: Path, simulate_with: str, budget_s: float | None = None) -> Facts:
    """Diagnose a bundle and write what was found, when `budget_s` is used up what is known by then.

    `simulate_with` says what the cell simulates: `model`, `baseline` (calibrated, without what was named) or `prior`.
    An interrupt ends it without an artifact: one of half a search would be taken for made.

    Raises:
        BadInput: the bundle is damaged or cannot support a diagnosis.
        NotConverged: a recording that the baseline cannot follow.
    """
    given = read_bundle(bundle)
    require_for_diagnosis(given)
    untold = cannot_tell(given)
    patience = Patience(budget_s)
    found = diagnose(given, progress=lambda share, what: report(share, 1.0, what), patience=patience)
    verdict, summary = verdict_of(given, found), summary_of(found, untold)
    model = physics_of(given, found.chosen.fit)
    baseline = physics_of(given, found.baseline.fit)
    prior = nominal_from_priors({name: vars(getattr(given.prior, name)) for name in type(given.prior).model_fields})
    models = {"model": model, "baseline": baseline, "prior": prior}
    for name, physics in models.items():
        write_physics(out / f"{name}.yaml", physics)
    cell = cell_physics(models[simulate_with])
    write_physics(out / "cell.yaml", cell)
    left_out = effects_left_out(model, cell)
    write_json(out / "verdict.json", verdict)
    write_json(out / "summary.json", summary)
    draw_pictures(out, given, found)
    report(1.0, 1.0, "done")
    return {
        "verdict": verdict.verdict,
        "effects": ", ".join(summary.effects) or "none",
        "simulated": simulate_with,
        "effects_not_simulated": ", ".join(left_out) or "none",
        "heldout_recordings": ", ".join(summary.heldout),
        "baseline_heldout": in_mm(verdict.rmse_m.baseline.heldout),
        "model_heldout": in_mm(verdict.rmse_m.augmented.heldout),
        "noise_mm": round(1e3 * verdict.noise_std_m, 3),
        "parameters": [{name: _short(value) for name, value in row} for row in summary.estimates],
    }


def _short(value: str | float) -> str | float:
    return value if isinstance(value, str) else float(f"{value:.4g}")
