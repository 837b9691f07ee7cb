"""One diagnosis of a bundle from `benchmarks.concealed`, beside its answers."""

import json
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pydantic
from scipy.interpolate import interp1d
from sklearn.metrics import roc_auc_score

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.assimilate import Forces
from sim1.mismatch.decide import THRESHOLDS, mean_square, rating
from sim1.mismatch.diagnose import Diagnosis, diagnose
from sim1.mismatch.findings import verdict_of
from sim1.mismatch.fit import Fit, cost_of
from sim1.mismatch.model_file import deviations, interval
from sim1.recording.bundle import read_bundle

ACTS = 0.1  # of the largest force per area: from there on something acts
LOCAL = 0.002, 0.5  # shares of markers and frames between which an effect is called local


class Number(pydantic.BaseModel):
    """A coefficient that was found; `true` is None where nothing of that name was concealed."""

    value: float
    low: float
    high: float
    true: float | None


class Trial(pydantic.BaseModel):
    """What became of one case."""

    case: str
    concealed: list[str]
    vertices: int
    places_given: bool
    verdict: str
    named: list[str]  # best model's effects, if the verdict speaks of any
    gains: dict[str, float]  # of the models that were fitted, over the baseline, nats
    misfits: dict[str, float]  # of all models, the baseline under ""
    costs: dict[str, dict[str, tuple[float, float]]]  # likewise, by recording: nats, and mean square
    effects: dict[str, dict[str, Number]]
    baseline: dict[str, Number]
    fit_mm: tuple[float, float]  # baseline, augmented, from rest and drives alone
    heldout_mm: tuple[float, float]
    misfit: tuple[float, float]
    place_auc: float | None  # see `place_auc`; None: force was concealed nowhere or everywhere
    seconds: float
    simulating_s: float

    @property
    def right(self) -> bool:
        """Whether the verdict is the one that was asked for."""
        if not self.concealed:
            return self.verdict == "none"
        if not set(self.concealed) <= set(EFFECTS):  # outside the table
            return self.verdict in ("unknown", "ambiguous")
        return self.verdict == "named" and sorted(self.named) == sorted(self.concealed)


def _by_recording(fit: Fit) -> dict[str, tuple[float, float]]:
    return {name: (cost_of(fit.residuals, (name,), fit.temper), mean_square(fit, (name,))) for name in fit.names}


def run_trial(folder: Path) -> Trial:
    """Diagnose `folder/bundle`; `folder/answers.json` is read when that is over."""
    began = time.perf_counter()
    bundle = read_bundle(folder / "bundle")
    found = diagnose(bundle)
    seconds = time.perf_counter() - began
    answers = json.loads((folder / "answers.json").read_text())
    true = {effect["name"]: effect["parameters"] for effect in answers["effects"]}
    verdict = verdict_of(bundle, found)
    errors = verdict.rmse_m
    return Trial(
        case=folder.name,
        concealed=sorted(true),
        vertices=len(bundle.mesh.vertices_m),
        places_given=answers["places_given"],
        verdict=verdict.verdict,
        named=sorted(effect.name for effect in verdict.missing_physics),
        gains=_gains(found),
        misfits={" + ".join(model.terms): mean_square(model.fit) for model in found.models},
        costs={" + ".join(model.terms): _by_recording(model.fit) for model in found.models},
        effects={
            effect.name: {
                name: Number(value=c.value, low=c.ci95[0], high=c.ci95[1], true=true.get(effect.name, {}).get(name))
                for name, c in effect.parameters.items()
                if c.ci95 is not None
            }
            for effect in verdict.missing_physics
        },
        baseline=_baseline(found, answers["baseline"]),
        fit_mm=(1e3 * errors.baseline.fit, 1e3 * errors.augmented.fit),
        heldout_mm=(1e3 * errors.baseline.heldout, 1e3 * errors.augmented.heldout),
        misfit=(found.misfit["baseline"], found.misfit["chosen"]),
        place_auc=place_auc(found.located.forces, np.load(folder / "answers.npz")),
        seconds=seconds,
        simulating_s=found.simulating_s,
    )


def place_auc(forces: tuple[Forces, ...], answers: Mapping[str, np.ndarray]) -> float | None:
    """Area under the ROC curve: size of the located force at markers and frames, against `ACTS` of the largest concealed one."""
    sizes, concealed = [], []
    for force in forces:
        size = np.linalg.norm(force.force_n, axis=-1)
        sizes.append(
            interp1d(force.time_s, size, axis=0, bounds_error=False, fill_value=(size[0], size[-1]))(
                answers[f"{force.name}/stamps_s"]
            )
        )
        concealed.append(answers[f"{force.name}/missing_n_m2"])
    most = max((float(part.max()) for part in concealed), default=0.0)
    acts = np.concatenate([part.ravel() > ACTS * most for part in concealed])
    if most == 0.0 or not LOCAL[0] < acts.mean() < LOCAL[1]:
        return None
    return float(roc_auc_score(acts, np.concatenate([part.ravel() for part in sizes])))


def _gains(found: Diagnosis) -> dict[str, float]:
    null = rating(found.baseline, THRESHOLDS)
    return {" + ".join(model.terms): null - rating(model, THRESHOLDS) for model in found.models if model.terms}


def _baseline(found: Diagnosis, true: dict[str, float]) -> dict[str, Number]:
    fit, numbers = found.chosen.fit, {}
    for c, z, deviation in zip(fit.unknowns.nominal, fit.z, deviations(fit), strict=False):
        if c.name in true:
            low, high = interval(c, z, deviation)
            numbers[c.name] = Number(value=c.value(z), low=low, high=high, true=true[c.name])
    return numbers
