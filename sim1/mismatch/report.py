"""From a calibration to a verdict and a page for a person who has ten minutes."""

import base64
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from sim1.mismatch.locate import Location, locate, signature
from sim1.mismatch.pictures import draw_place
from sim1.mismatch.verdict import Verdict, write_verdict
from sim1.recording.bundle import Bundle, read_bundle
from sim1.stage import BadInput, Facts


def write_report(recordings: Path, calibration: Path, out: Path, config) -> Facts:
    """Write `verdict.json`, `report.html` and pictures; `config` is a `MismatchReportConfig`.

    Raises:
        BadInput: the bundle or the calibration is not readable, or they do not belong together.
    """
    bundle = read_bundle(recordings / "bundle")
    fit, simulated = _calibration(calibration, bundle)
    virtual = json.loads((recordings / "origin.json").read_text())["virtual"]
    before, after = fit["baseline"], fit["augmented"] or fit["baseline"]
    location = locate(bundle.recordings, simulated["baseline"], before["floor_heldout_m"])
    mismatch = before["rmse_heldout_m"] > config.none_ratio * before["floor_heldout_m"]
    word = "named" if fit["accepted"] and mismatch else "unknown" if mismatch else "none"
    verdict = _verdict(word, fit, location, bundle)
    write_verdict(out / "verdict.json", verdict)
    draw_place(out / "place.png", bundle, location, "Unexplained by the calibrated baseline")
    if word == "named":
        rest = locate(bundle.recordings, simulated["augmented"], after["floor_heldout_m"])
        draw_place(out / "place_after.png", bundle, rest, "Still unexplained with air drag")
    pictures = [(calibration / "heldout.png", "Held-out motion"), (calibration / "parameters.png", "Parameters")]
    pictures.append((out / "place.png", "Where and when, before"))
    if word == "named":
        pictures.append((out / "place_after.png", "Where and when, with air drag"))
    sentence = _sentence(word, fit)
    _page(
        out / "report.html",
        verdict=verdict,
        fit=fit,
        sentence=sentence,
        virtual=virtual,
        pictures=pictures,
        config=config,
    )
    return {
        "verdict": word,
        "sentence": sentence,
        "recordings_are": "a stand-in lab (simulated)" if virtual else "real",
        "baseline_heldout_mm": round(1e3 * before["rmse_heldout_m"], 3),
        "augmented_heldout_mm": round(1e3 * after["rmse_heldout_m"], 3),
        "noise_mm": round(1e3 * fit["noise_std_m"], 3),
    }


def _calibration(folder: Path, bundle: Bundle) -> tuple[dict[str, Any], dict[str, dict[str, np.ndarray]]]:
    simulated: dict[str, dict[str, np.ndarray]] = {"baseline": {}, "augmented": {}}
    try:
        fit = json.loads((folder / "fit.json").read_text())
        with np.load(folder / "predictions.npz", allow_pickle=False) as data:
            for key in data.files:
                kind, name = key.split("/", 1)
                simulated[kind][name] = data[key].astype(float)
    except (OSError, ValueError, KeyError) as error:
        raise BadInput(f"{folder}: not a readable calibration ({error}); make calibrated_physics again") from error
    for recording in bundle.recordings:
        found = simulated["baseline"].get(recording.name)
        if found is None or found.shape != recording.markers_m.shape:
            raise BadInput(
                f"{folder / 'predictions.npz'}: nothing that fits recording {recording.name}; make calibrated_physics again"
            )
    return fit, simulated


def _verdict(word: str, fit: dict[str, Any], location: Location, bundle: Bundle) -> Verdict:
    before, after = fit["baseline"], fit["augmented"]
    reduction = 1 - after["rmse_heldout_m"] / before["rmse_heldout_m"] if after else 0.0
    probability = _probability(fit)
    taken = after if word == "named" else before
    effects, others = [], []
    if word == "named":
        row = next(row for row in after["parameters"] if row["name"] == "c_normal")
        coefficient = {"value": row["value"], "ci95": (row["low"], row["high"]), "unit": row["unit"]}
        effects.append(
            {
                "name": "air_drag",
                "probability": probability,
                "parameters": {"c_normal": coefficient},
                "heldout_rmse_reduction": reduction,
            }
        )
    elif after:
        why = f"it changes the held-out error by {100 * -reduction:+.1f} % and closes {100 * fit['excess_closed']:.0f} % of the excess over noise and mesh"
        others.append({"name": "air_drag", "probability": probability, "why_not": why})
    columns, share = location.region()
    region = (
        [{"markers": [int(bundle.anchors.marker[k]) for k in columns], "share": min(share, 1.0)}]
        if columns and word != "none"
        else []
    )
    windows = [vars(window) for window in location.worst_windows()] if word != "none" else []
    return Verdict.model_validate(
        {
            "verdict": word,
            "schema": "sim1.verdict/1",
            "noise_std_m": fit["noise_std_m"],
            "rmse_m": {
                "baseline": {"fit": before["rmse_fit_m"], "heldout": before["rmse_heldout_m"]},
                "augmented": {"fit": taken["rmse_fit_m"], "heldout": taken["rmse_heldout_m"]},
            },
            "mismatch": {
                "regions": region,
                "windows": windows,
                "signature": signature(location, before["floor_heldout_m"], before["rmse_heldout_m"]),
            },
            "missing_physics": effects,
            "alternatives": others,
            "next_experiment": _next(word),
        }
    )


def _probability(fit: dict[str, Any]) -> float:
    """Of air drag against the baseline alone, from the held-out score and its independent samples; other effects are not weighed."""
    if not fit["augmented"]:
        return 0.0
    independent = fit["baseline"]["heldout_samples"] / fit["baseline"]["inflation"]
    return 1 / (1 + math.exp(-max(-7.0, min(7.0, fit["heldout_gain"] * independent - 1.0))))


def _next(word: str) -> str:
    if word == "named":
        return (
            "Swing the same cloth at half and at twice the speed: drag grows with the square of speed, carried air (added mass) with "
            "acceleration. This version's library holds drag alone, so it cannot tell them apart."
        )
    if word == "unknown":
        return "Repeat the motion slower, and once with the cloth held still after a pull: what vanishes tells speed from stiffness and slip."
    return "None needed for this difference; a faster swing would show effects that grow with speed."


def _sentence(word: str, fit: dict[str, Any]) -> str:
    before, after = fit["baseline"], fit["augmented"]
    error, floor = 1e3 * before["rmse_heldout_m"], 1e3 * before["floor_heldout_m"]
    if word == "none":
        return f"Nothing is missing that these recordings could show: {error:.2f} mm on held-out motion, where noise and mesh explain {floor:.2f} mm."
    if word == "named":
        return f"Air drag was left out: with it, the error on held-out motion falls from {error:.2f} to {1e3 * after['rmse_heldout_m']:.2f} mm."
    return f"Something is missing and has no name here: {error:.2f} mm on held-out motion, where noise and mesh explain {floor:.2f} mm."


def _page(path: Path, *, pictures: list[tuple[Path, str]], **values: Any) -> None:
    loader = FileSystemLoader(Path(__file__).parent)
    template = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template("report.html.jinja")
    images = [(base64.b64encode(file.read_bytes()).decode(), caption) for file, caption in pictures]
    path.write_text(template.render(images=images, **values))
