"""The oracle: a model that is told what was concealed, fitted like any other. What it gains held out is all there was to gain."""

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sim1.cloth.physics import ClothPhysics
from sim1.proof.again import Films
from sim1.proof.answers import REMEDY, Answers, read_answers, read_courses
from sim1.proof.files import Files, Oracle, write_model
from sim1.proof.outcome import Outcome
from sim1.proof.unseen import motions_of, off_m
from sim1.recording.bundle import Bundle, read_bundle
from sim1.stage import BadInput

if TYPE_CHECKING:
    from sim1.mismatch.search import Unknowns


def ask_oracle(films: Films, outcomes: tuple[Outcome, ...]) -> None:
    """Ask of every case with effects of the table that has been diagnosed, here or elsewhere, and not been asked yet.

    Raises:
        BadInput: a bundle or its answers are damaged.
    """
    from sim1.cloth.precise.simulate import NotConverged

    files = films.files
    asked = [one for one in outcomes if one.kind in ("single", "several") and one.found]
    for number, one in enumerate(asked, start=1):
        if one.oracle_s is not None or (filmed := films.of(one.case)) is None:
            continue
        began = time.monotonic()
        fabric = {name: n.true for name, n in one.found.fabric.items() if n.true is not None}
        answers = read_answers(filmed.answers(one.case))
        bundle, heldout_mm, unseen_mm, lost = read_bundle(filmed.bundle(one.case)), None, None, {}
        try:
            heldout, told = heldout_m(bundle, concealed(answers), fabric, one.found.heldout_of(bundle))
            heldout_mm = 1e3 * heldout
        except NotConverged as error:
            lost["heldout"] = str(error)
        else:
            try:
                unseen_mm = _unseen_mm(filmed, one.case, told)
            except NotForetold as error:
                lost["unseen"] = str(error)
        seconds = round(time.monotonic() - began, 3)
        answer = Oracle(case=one.case, heldout_mm=heldout_mm, unseen_mm=unseen_mm, lost=lost, seconds=seconds)
        write_model(files.oracle(one.case), answer)
        said = (
            "no simulation of the oracle found its way"
            if heldout_mm is None
            else f"the oracle is off by {heldout_mm:.2f} mm"
        )
        films.tell(f"{one.case}: {said}; {number} of {len(asked)} asked")


def concealed(answers: Answers) -> dict[str, dict[str, float]]:
    """True values by effect, with those that the format's table has no name for."""
    return {effect.name: effect.extras | effect.parameters for effect in answers.effects}


class NotForetold(RuntimeError):
    """No simulation of the oracle's model follows motions that no diagnosis was given; the message says why."""


def _unseen_mm(files: Files, case: str, told: ClothPhysics) -> float | None:
    """Error of the oracle's model on motions that no diagnosis was given [mm]; None: they are not here.

    Raises:
        BadInput: their bundle or its answers are damaged, or do not fit each other.
        NotForetold: as it says.
    """
    from sim1.cloth.precise.simulate import NotConverged
    from sim1.mismatch.predict import predict

    if not files.unseen(case).is_dir():
        return None
    path = files.answers(case).with_suffix(".npz")
    courses, bundle = read_courses(path), read_bundle(files.unseen(case))
    try:
        table = predict(bundle, told)
    except (NotConverged, BadInput) as error:  # a sheet that snaps, or a grip that no recording showed
        raise NotForetold(str(error)) from error
    try:
        return 1e3 * off_m(table, courses, motions_of(files.unseen(case)))
    except (KeyError, ValueError) as error:
        raise BadInput(f"{path}: not the motions of {files.unseen(case)} ({error}); {REMEDY}") from error


def heldout_m(
    bundle: Bundle, effects: Mapping[str, Mapping[str, float]], fabric: Mapping[str, float], held: str
) -> tuple[float, ClothPhysics]:
    """Error [m] on the recording `held` of the model with these effects, fitted from these values to the other recordings, and the model.

    Raises:
        NotConverged: no simulation of it found its way.
    """
    from sim1.mismatch.engine import Engine
    from sim1.mismatch.heldout import rmse_of
    from sim1.mismatch.model_file import physics_of
    from sim1.mismatch.models import calibrate

    model, z = as_told(bundle, effects, fabric)
    with Engine(bundle) as engine:
        names = tuple(name for name in engine.names if name != held)
        found = calibrate(engine, model, z, names, lambda share: None)
        markers = engine.foretell(model.world(found.z), (held,))
    return rmse_of(bundle, markers, (held,)), physics_of(bundle, found)


def as_told(
    bundle: Bundle, effects: Mapping[str, Mapping[str, float]], fabric: Mapping[str, float]
) -> tuple["Unknowns", np.ndarray]:
    """The model with these effects, and its z where they and the fabric have these values."""
    from sim1.cloth.effects import EFFECTS
    from sim1.mismatch.search import Term, baseline

    plain = baseline(bundle)
    about_origin = replace(plain.base, frame_centre_m=(0.0, 0.0, 0.0))  # as answers tell a frame
    plain = replace(plain, base=about_origin)
    start = [c.z(fabric[c.name]) if c.name in fabric else 0.0 for c in plain.nominal]
    terms = []
    for name, told in effects.items():
        true = EFFECTS[name].searched(dict(told))
        shapes = {c.name: true[c.name] for c in EFFECTS[name].coefficients if c.shape and c.name in true}
        terms.append(Term.of(EFFECTS[name], shapes))
        start += [0.0 if c.shape or c.name not in true else c.z(true[c.name]) for c in terms[-1].coefficients]
    return plain.with_terms(*terms), np.array(start)
