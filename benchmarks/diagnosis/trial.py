"""One diagnosis of a bundle from `benchmarks.concealed`, beside its answers."""

import json
import time
from pathlib import Path

import pydantic

from sim1.mismatch.decide import THRESHOLDS, rating
from sim1.mismatch.diagnose import Diagnosis, diagnose
from sim1.mismatch.findings import verdict_of
from sim1.mismatch.model_file import deviations, interval
from sim1.recording.bundle import read_bundle


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
    effects: dict[str, dict[str, Number]]
    baseline: dict[str, Number]
    heldout_mm: tuple[float, float]  # baseline, augmented
    misfit: tuple[float, float]
    seconds: float
    simulating_s: float

    @property
    def right(self) -> bool:
        """Whether the verdict is the one that was asked for."""
        if not self.concealed:
            return self.verdict == "none"
        return self.verdict == "named" and sorted(self.named) == sorted(self.concealed)


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
        effects={
            effect.name: {
                name: Number(value=c.value, low=c.ci95[0], high=c.ci95[1], true=true.get(effect.name, {}).get(name))
                for name, c in effect.parameters.items()
                if c.ci95 is not None
            }
            for effect in verdict.missing_physics
        },
        baseline=_baseline(found, answers["baseline"]),
        heldout_mm=(1e3 * errors.baseline.heldout, 1e3 * errors.augmented.heldout),
        misfit=(found.misfit["baseline"], found.misfit["chosen"]),
        seconds=seconds,
        simulating_s=found.simulating_s,
    )


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
