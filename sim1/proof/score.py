"""One diagnosis beside its answers: what was concealed, what was found, how far off."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sim1.mismatch.strict_json import Strict, read_json
from sim1.mismatch.summary import SCHEMA, read_summary
from sim1.mismatch.verdict import Verdict, read_verdict
from sim1.proof.answers import Answers, kind_of, read_answers, read_courses
from sim1.proof.draw import Case
from sim1.proof.files import Baselines, Files, Oracle, Record
from sim1.proof.outcome import Found, Number, Outcome, is_right
from sim1.proof.ranking import BASELINE, first_single, least_misfit, over_limit
from sim1.proof.unseen import MODELS, motions_of, off_mm
from sim1.stage import BadInput

FABRIC = ("area_density_kg_m2", "stretch_n_m", "poisson", "bending_n_m", "damping_s")


class OtherCode(BadInput):
    """What a diagnosis wrote has another schema than this code reads: no fault of the diagnosis."""


def score(files: Files, asked: Case, record: Record) -> Outcome:
    """Set a finished case against its answers. A diagnosis that failed, or wrote no verdict, counts as wrong.

    Raises:
        BadInput: the answers are at fault, or what was foretold is damaged.
        OtherCode: the diagnosis was made by code that wrote other files.
    """
    answers = read_answers(files.answers(record.case), asked)
    verdict, found, error, unseen_mm = None, None, record.error, None
    if error is None:
        courses = read_courses(files.answers(record.case).with_suffix(".npz"), motions_of(files.bundle(record.case)))
        try:
            verdict, found = _found(files, record.case, answers, courses)
        except BadInput as damage:
            if (schema := _schema(files.found(record.case) / "summary.json")) != SCHEMA:
                raise OtherCode(
                    f"{files.found(record.case)}/summary.json: schema {schema}, this code reads {SCHEMA}: score the campaign with the code "
                    f"that diagnosed it ({record.code_sha256[:12]})"
                ) from damage
            error = str(damage)
        else:
            unseen_mm = _unseen_mm(files, record.case, courses)
    named = tuple(sorted(effect.name for effect in verdict.missing_physics)) if verdict else ()
    said = verdict.verdict if verdict else "failed"
    kind = kind_of(answers)
    concealed = {effect.name: effect.parameters for effect in answers.effects}
    return Outcome(
        case=record.case,
        kind=kind,
        concealed=concealed,
        strength=answers.case.strength,
        reached=answers.reached,
        seed=answers.case.seed,
        places_given=answers.places_given,
        verdict=said,
        named=named,
        right=is_right(kind, tuple(concealed), said, named),
        error=error,
        seconds=record.seconds or 0.0,
        code_sha256=record.code_sha256,
        code_changed=record.code_changed,
        found=found,
        unseen_mm=unseen_mm,
        not_foretold=record.not_foretold,
        **asked_besides(files, record.case),
    )


def asked_besides(files: Files, case: str) -> dict[str, Any]:
    """What oracle and baselines said of a case, as fields of an `Outcome`; of those that were not asked here, none."""
    oracle, baselines = _asked(files.oracle(case), Oracle), _asked(files.baselines(case), Baselines)
    told = {} if baselines is None else {"baselines": baselines}
    if oracle is None:
        return told
    return told | {
        "oracle_mm": oracle.heldout_mm,
        "oracle_unseen_mm": oracle.unseen_mm,
        "oracle_s": oracle.seconds,
        "oracle_lost": oracle.lost,
    }


def _unseen_mm(files: Files, case: str, courses: Mapping[str, np.ndarray]) -> tuple[float | None, ...] | None:
    """Errors of the diagnosis' models on motions that it was not given; None where there are none.

    Raises:
        BadInput: predictions are damaged.
    """
    if not files.unseen(case).is_dir():
        return None
    motions = motions_of(files.unseen(case))
    return tuple(off_mm(files.foretold(case, model), courses, motions) for model in MODELS)


def _schema(path: Path) -> str:
    """What a file says it is; what is damaged is taken to be what it should be."""
    try:
        return str(json.loads(path.read_bytes())["schema"])
    except (OSError, ValueError, KeyError, TypeError):
        return SCHEMA


def _asked[T: Strict](path: Path, kind: type[T]) -> T | None:
    return read_json(path, kind, "remove it and ask again") if path.is_file() else None


def _found(files: Files, case: str, answers: Answers, courses: Mapping[str, np.ndarray]) -> tuple[Verdict, Found]:
    from sim1.cloth.physics import ClothPhysics, read_physics

    folder = files.found(case)
    verdict, summary = read_verdict(folder / "verdict.json"), read_summary(folder / "summary.json")
    model: ClothPhysics = read_physics(folder / "model.yaml")
    true = {effect.name: effect.parameters for effect in answers.effects}
    properties = {name: getattr(model, name) for name in FABRIC} | {"friction": model.friction.table}
    before, after = verdict.rmse_m.baseline, verdict.rmse_m.augmented
    return verdict, Found(
        first=first_single(summary),
        gains={row.name: row.gain for row in summary.ranking if row.name != BASELINE},
        worths={row.name: row.worth for row in summary.ranking if row.name != BASELINE},
        established=tuple(row.name for row in summary.ranking if row.established and row.name != BASELINE),
        steady=tuple(row.name for row in summary.ranking if row.steady and row.name != BASELINE),
        heard={row.name: row.heard_worth for row in summary.ranking if row.heard_steady and row.name != BASELINE},
        least_misfit=least_misfit(summary),
        effects={
            effect.name: {
                name: Number(
                    value=c.value, low=c.ci95[0], high=c.ci95[1], unit=c.unit, true=_true(true, effect.name, name)
                )
                for name, c in effect.parameters.items()
                if c.ci95 is not None
            }
            for effect in verdict.missing_physics
        },
        fabric={
            name: Number(value=p.value, low=p.ci95[0], high=p.ci95[1], unit="", true=answers.baseline[name])
            for name, p in properties.items()
            if p.ci95 is not None and name in answers.baseline
        },
        misfit=(summary.misfit.baseline, summary.misfit.chosen),
        misfit_alone=summary.misfit.alone,
        misfit_heldout=summary.misfit.heldout,
        table=summary.misfit.table,
        heldout=summary.heldout,
        fit_mm=(_mm(before.fit), _mm(after.fit)),
        heldout_mm=(_mm(before.heldout), _mm(after.heldout)),
        spoken_for=summary.spoken_for,
        withdrawn=summary.withdrawn,
        place_auc=_place_auc(folder / "forces.npz", courses),
        over_limit={
            name: over for name, given in true.items() if (over := over_limit(summary, name, given)) is not None
        },
    )


def _place_auc(path: Path, courses: Mapping[str, np.ndarray]) -> float | None:
    """Of forces that a diagnosis wrote; raises BadInput where they are damaged, or of other recordings or markers."""
    from sim1.mismatch.forces_file import REMEDY as AGAIN
    from sim1.mismatch.forces_file import read_forces
    from sim1.proof.place import place_auc

    forces = read_forces(path)
    for name, (_, force_n) in forces.items():
        known = courses.get(f"{name}/missing_n_m2")
        if known is None or known.shape[1] != force_n.shape[1]:
            told = "nothing" if known is None else f"{known.shape[1]} markers"
            raise BadInput(
                f"{path}: {name}/force_n has {force_n.shape[1]} markers, the answers have {told} of it; {AGAIN}"
            )
    return place_auc(forces, courses)


def _mm(error_m: float | None) -> float | None:
    return None if error_m is None else 1e3 * error_m


def _true(true: Mapping[str, Mapping[str, float]], effect: str, parameter: str) -> float | None:
    value = true.get(effect, {}).get(parameter)
    return value if value is not None and math.isfinite(value) else None
