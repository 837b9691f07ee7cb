"""A diagnosis as files: `verdict.json`, `summary.json`, `model.yaml`, `baseline.yaml`, `forces.npz`, `report.html`."""

import math
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sim1.cloth.physics import write_physics
from sim1.mismatch.decide import null_of, rating, steady, worth, worth_over
from sim1.mismatch.destination import writable_folder, write_whole
from sim1.mismatch.detectable import detectable
from sim1.mismatch.diagnose import Diagnosis, diagnose
from sim1.mismatch.excess import on_table, worst
from sim1.mismatch.experiments import left_open, next_experiment
from sim1.mismatch.finding_pictures import draw_forces, draw_heldout_error, draw_key_frames
from sim1.mismatch.fit import Fit, promised
from sim1.mismatch.forces_file import write_forces
from sim1.mismatch.model_file import effect_entry, interval, physics_of
from sim1.mismatch.models import Model
from sim1.mismatch.page import write_page
from sim1.mismatch.patience import Patience
from sim1.mismatch.ranked import joined, ranked
from sim1.mismatch.strict_json import write_json
from sim1.mismatch.summary import SCHEMA, Prices, Summary, Undecided
from sim1.mismatch.thresholds import THRESHOLDS, Thresholds
from sim1.mismatch.uncertainty import deviations
from sim1.mismatch.verdict import Verdict, in_mm
from sim1.recording.bundle import Bundle, read_bundle
from sim1.recording.examination import cannot_tell
from sim1.recording.rules import Statement
from sim1.recording.sufficient import require_for_diagnosis
from sim1.recording.unspread import unspread

FILES = ("model.yaml", "baseline.yaml", "summary.json", "forces.npz", "verdict.json", "report.html")  # of a diagnosis
LOST = "it promised something, and no simulation with it found its way from rest to the end: not judged"
EASED = 4.0  # by which scores are divided before they are called odds
LEFT_NATS, LEFT_SHARE = 3.0, 0.02  # that a search may leave; the share is of what the verdict rests on


def run_diagnosis(
    bundle: Path, out: Path, progress: Callable[[float, str], None], budget_s: float | None = None
) -> Verdict:
    """`sim1 diagnose`: read, diagnose, write into `out` (made if missing).

    When `budget_s` is used up, or at Ctrl-C or `kill`, what is known by then is written. `baseline.yaml` is there as soon as the baseline
    is calibrated, in place of all that an earlier diagnosis left in `out`: what ends badly after that leaves no verdict of another bundle.

    Raises:
        BadInput: the bundle is damaged or cannot support a diagnosis, or `out` or a file in it cannot be written.
        NotConverged: a recording that the baseline cannot follow.
    """
    given = read_bundle(bundle)
    require_for_diagnosis(given)
    writable_folder(out)
    untold = cannot_tell(given)
    patience = Patience(budget_s)

    def keep(base: Fit) -> None:
        def write(path: Path) -> None:
            write_physics(path, physics_of(given, base))
            for name in reversed(FILES):  # no verdict without its model, whenever it ends
                (out / name).unlink(missing_ok=True)

        write_whole(out / "baseline.yaml", write)

    with patience.interruptible():
        found = diagnose(given, progress=progress, patience=patience, calibrated=keep)
        progress(0.97, "writing the report")
        write_whole(out / "model.yaml", lambda path: write_physics(path, physics_of(given, found.chosen.fit)))
        write_whole(out / "baseline.yaml", lambda path: write_physics(path, physics_of(given, found.baseline.fit)))
        verdict, summary = verdict_of(given, found), summary_of(found, untold)
        write_whole(out / "summary.json", lambda path: write_json(path, summary))
        write_whole(out / "forces.npz", lambda path: write_forces(path, found.located.forces))
        write_whole(out / "verdict.json", lambda path: write_json(path, verdict))
        with tempfile.TemporaryDirectory() as pictures:
            draw_pictures(Path(pictures), given, found)
            write_whole(out / "report.html", lambda path: write_page(path, verdict, summary, Path(pictures)))
    progress(1.0, "done")
    return verdict


def verdict_of(bundle: Bundle, found: Diagnosis, thresholds: Thresholds = THRESHOLDS) -> Verdict:
    """The answer for programs."""
    chances = probabilities(admitted(found, thresholds), found.verdict, thresholds)
    chances |= {name: 0.0 for model in found.models for name in model.terms if name not in chances}
    columns, share = found.located.region()
    ids = bundle.anchors.marker
    before, after = found.rmse_m["baseline"], found.rmse_m["augmented"]
    effects = []
    if found.verdict in ("named", "ambiguous"):
        for index in range(len(found.chosen.fit.unknowns.terms)):
            entry = effect_entry(found.chosen.fit, index)
            reduction = _reduction(found.heldout_without_m[entry["name"]], after["heldout"])
            chance = chances.get(entry["name"], 0.0)
            effects.append({**entry, "probability": chance, "heldout_rmse_reduction": reduction})
        effects.sort(key=lambda entry: -entry["probability"])
    named = {entry["name"] for entry in effects}
    others = [
        {"name": name, "probability": chance, "why_not": _why_not(name, found, thresholds)}
        for name, chance in sorted(chances.items(), key=lambda item: -item[1])
        if name not in named
    ][:6]
    others += [{"name": name, "probability": 0.0, "why_not": LOST} for name in lost_names(found) if name not in named]
    missing = found.verdict != "none"
    return Verdict.model_validate(
        {
            "schema": "sim1.verdict/1",
            "verdict": found.verdict,
            "noise_std_m": found.noise_m,
            "rmse_m": {"baseline": before, "augmented": after},
            "mismatch": {
                "regions": [{"markers": [int(ids[k]) for k in columns], "share": share}] if missing and columns else [],
                "windows": [vars(window) for window in found.located.worst_windows()] if missing else [],
                "signature": found.located.signature,
            },
            "missing_physics": effects,
            "alternatives": others,
            "next_experiment": next_experiment(found),
            "remarks": [*found.remarks, *unspread(bundle)],
        }
    )


def _reduction(before_m: float | None, after_m: float | None) -> float | None:
    """By what share of itself an error falls; None where one of the two is not known."""
    return 1.0 - after_m / before_m if before_m and after_m is not None else None


def admitted(found: Diagnosis, thresholds: Thresholds) -> tuple[Model, ...]:
    """Models that a verdict leaves standing: one that rates better than a named one, and is no rival, was refused by its rules."""
    if found.verdict not in ("named", "ambiguous"):
        return found.models
    models = found.heard or found.models
    standing = {found.chosen.terms, *(rival.terms for rival in found.rivals)}
    best = rating(next(one for one in models if one.terms == found.chosen.terms), thresholds)
    return tuple(model for model in models if rating(model, thresholds) >= best or model.terms in standing)


def probabilities(models: tuple[Model, ...], verdict: str, thresholds: Thresholds) -> dict[str, float]:
    """Posterior share of every effect over the models that were fitted, scores eased by what nulls scatter.

    Even odds with the baseline are where a name begins. Where the verdict is `unknown`, something that no model holds is as probable as all
    of them together.
    """
    null = null_of(list(models))
    scores = np.array(
        [thresholds.named - worth_over(null, model, thresholds) if model.terms else 0.0 for model in models]
    )
    weight = np.exp(-(scores - scores.min()) / EASED)
    weight /= weight.sum() * (2.0 if verdict == "unknown" else 1.0)
    chances: dict[str, float] = {}
    for model, share in zip(models, weight, strict=True):
        for name in model.terms:
            chances[name] = chances.get(name, 0.0) + float(share)
    return {name: min(max(chance, 0.0), 1.0) for name, chance in chances.items()}


def _why_not(name: str, found: Diagnosis, thresholds: Thresholds) -> str:
    mine = [model for model in found.models if name in model.terms]
    best = min(mine, key=lambda model: rating(model, thresholds))
    behind = rating(best, thresholds) - rating(found.chosen, thresholds)
    name_s_worth = worth_over(found.baseline, best, thresholds) >= thresholds.named
    stands = name_s_worth and steady(list(found.models), best, thresholds, found.measured)
    if behind < 0 and found.verdict == "unknown" and stands:
        return f"{joined(best)} gains {-behind:.1f} nats over the baseline, but explains too little of what is missing or foretells held-out motion worse"
    if behind < 0 and not found.chosen.terms:
        least = worth([found.baseline], best, thresholds)
        return f"{joined(best)} gains {-behind:.1f} nats over the baseline, {least:.1f} where evidence that counts the same error again and again counts it once: no name's worth, or its strength may be nothing or differs from second to second"
    if behind < 0:
        return f"it gains {-behind:.1f} nats beside {joined(found.chosen)}: less than a further effect has to, or too little is explained with both"
    return f"{joined(best)} explains {behind:.1f} nats less of the motion than {joined(found.chosen)}"


def lost_names(found: Diagnosis) -> list[str]:
    """Effects that promised something and were never simulated to the end."""
    judged = {name for model in found.models for name in model.terms}
    return sorted({candidate.term.effect.name for candidate in found.lost} - judged)


def sentence(found: Diagnosis) -> str:
    """The verdict in one sentence."""
    if found.stopped and not found.chosen.terms:
        return "The search was stopped before it found anything: diagnose again with more time."
    before, after = (in_mm(found.rmse_m[label]["heldout"]) for label in ("baseline", "augmented"))
    if found.verdict == "none":
        return f"Nothing is missing that these recordings could show: {before} on held-out motion."
    left = found.misfit["chosen"]
    more = ""
    if left > THRESHOLDS.misfit:
        more = f" The mean square of what is left is {left:.1f} times what noise and mesh explain: that is not all."
    if found.verdict == "named":
        return f"Left out: {joined(found.chosen)}. With it the error on held-out motion goes from {before} to {after}.{more}"
    if found.verdict == "ambiguous":
        rivals = ", ".join(joined(rival) for rival in found.rivals)
        return f"Something was left out, and {joined(found.chosen)} explains it no better than {rivals} ({before} to {after} held out).{more}"
    nearest = f"; {joined(found.models[0])} comes nearest and is not borne out" if found.models[0].terms else ""
    return f"Something was left out that no known effect explains: {before} on held-out motion{nearest}."


def summary_of(found: Diagnosis, untold: Sequence[Statement], thresholds: Thresholds = THRESHOLDS) -> Summary:
    """What the page says beyond the verdict; `untold`: what recordings like these cannot tell (`examination.cannot_tell`)."""
    left = left_open(found)
    return Summary.model_validate(
        {
            "schema": SCHEMA,
            "sentence": sentence(found),
            "fitted": found.fitted,
            "heldout": found.heldout,
            "heldout_nats": found.against,
            "spoken_for": found.spoken_for,
            "withdrawn": found.withdrawn,
            "converged": _settled(found),
            "creep_m": found.creep_m,
            "misfit": {
                **found.misfit,
                "limit": thresholds.misfit,
                "alone": worst(found.baseline.fit),
                "heldout": found.left_heldout,
                "table": on_table(found.baseline.fit),
            },
            "prices": {name: getattr(thresholds, name) for name in Prices.model_fields},
            "ranking": ranked(found, thresholds),
            "estimates": _parameters(found),
            "effects": found.chosen.terms,
            "detectable": [vars(row) for row in detectable(found.screened, thresholds)],
            "undecided": [
                *([left] if left else []),
                *(Undecided(what=said.text, record=said.record) for said in untold),
            ],
            "states": [vars(row) for row in found.located.states],
        }
    )


def draw_pictures(folder: Path, bundle: Bundle, found: Diagnosis) -> None:
    """Draw the pictures of the page (`CAPTIONS`) into a folder."""
    draw_forces(folder / "forces.png", bundle, found)
    draw_heldout_error(folder / "heldout_error.png", bundle, found)
    draw_key_frames(folder / "key_frames.png", bundle, found)


def _parameters(found: Diagnosis) -> list[dict[str, Any]]:
    rows, fit = [], found.chosen.fit
    for c, z, deviation in zip(fit.unknowns.all, fit.z, deviations(fit), strict=True):
        low, high = interval(c, z, deviation)
        rows.append(
            {"name": c.name, "unit": c.unit, "prior": c.value(0.0), "value": c.value(z), "low": low, "high": high}
        )
    return [row for row in rows if not math.isnan(row["value"])]


def _settled(found: Diagnosis) -> bool:
    """Whether what more searching promises is small beside what decided."""
    gain = rating(found.baseline, THRESHOLDS) - rating(found.chosen, THRESHOLDS)
    least = max(LEFT_NATS, LEFT_SHARE * gain)
    return all(fit.converged or promised(fit) < least for fit in (found.baseline.fit, found.chosen.fit))
