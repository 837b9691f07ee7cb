"""The whole diagnosis of a bundle: measure, calibrate, locate, name, model, decide."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sim1.mismatch.assimilate import Located, locate_forces
from sim1.mismatch.borne_out import borne_out, doubtful, parts_of, with_doubtful
from sim1.mismatch.contest import contest
from sim1.mismatch.decide import decide, rating
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Tempers
from sim1.mismatch.foretold import foretold_by, nats_against
from sim1.mismatch.heldout import held_out, rmse_of
from sim1.mismatch.models import Model
from sim1.mismatch.patience import Patience
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import baseline
from sim1.mismatch.thresholds import THRESHOLDS, Thresholds
from sim1.recording.bundle import Bundle
from sim1.recording.lateness import is_late
from sim1.stage import BadInput

DELAYS = frozenset(
    {"clock_offset", "actuator_lag"}
)  # what makes markers come late, as can be measured without simulating


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """What was found, before it is put into words."""

    fitted: tuple[str, ...]
    heldout: tuple[str, ...]
    temper: Tempers
    noise_m: float
    creep_m: float  # of markers over the cloth; 0: none seen
    baseline: Model
    models: tuple[Model, ...]  # every model that was fitted, best first, the baseline among them
    chosen: Model
    screened: tuple[Candidate, ...]  # beside the baseline: every effect that the recordings could show
    lost: tuple[Candidate, ...]  # effects that promised something and that no simulation followed
    stopped: bool  # before all was tried
    verdict: str
    rivals: tuple[Model, ...]  # that explain it about as well
    misfit: dict[str, float]  # mean squared residual of baseline and chosen on what was fitted
    withdrawn: tuple[str, ...]  # names that motion held out took back
    against: float  # nats by which it is less likely with what was named, or withdrawn, than with the baseline
    rmse_m: dict[str, dict[str, float]]
    heldout_markers_m: dict[str, dict[str, np.ndarray]]  # baseline, augmented: recording -> (N, M, 3)
    located: Located  # what the chosen model has and the baseline has not; what is missing, if nothing was chosen
    simulating_s: float  # of the time that it took


def diagnose(
    bundle: Bundle,
    *,
    thresholds: Thresholds = THRESHOLDS,
    progress: Callable[[float, str], None] = lambda s, w: None,
    patience: Patience | None = None,
) -> Diagnosis:
    """Diagnose a bundle; what is known when `patience` ends is reported.

    Raises:
        BadInput: fewer than two recordings.
    """
    if len(bundle.recordings) < 2:
        raise BadInput(
            f"bundle.yaml: {len(bundle.recordings)} recording; a diagnosis needs two or more, one of them to test what the others taught"
        )
    with Engine(bundle, patience=patience) as engine:
        return _diagnose(engine, bundle, thresholds, progress)


def _diagnose(
    engine: Engine, bundle: Bundle, thresholds: Thresholds, progress: Callable[[float, str], None]
) -> Diagnosis:
    heldout = (held_out(bundle),)
    fitted = tuple(name for name in engine.names if name not in heldout)
    found = contest(engine, baseline(bundle), fitted, thresholds, lambda s, what: progress(0.02 + 0.78 * s, what))
    delays, stopped = delays_measured(bundle), engine.patience.over
    decision = decide(found.pool, thresholds, delays)
    progress(0.8, "checking on motion held out")
    foretold = {"baseline": foretold_by(engine, decision.null, engine.names)}
    named, more = decision.chosen, None if stopped else doubtful(decision, found.pool, thresholds)
    told = {(): {name: foretold["baseline"][name] for name in heldout}}  # by effects
    others = [] if stopped else [*parts_of(found.pool, more or named), *([more] if more else [])]
    if others:  # where one of them leads in the end and leaves too much, a delay that was measured does
        others += [one for one in found.pool if one.terms and set(one.terms) <= delays]
    asked = list({one.terms: one for one in (named, *others)}.values()) if named.terms else []
    told |= {model.terms: foretold_by(engine, model, heldout) for model in asked}
    against = nats_against(engine, decision.null, asked, told, heldout)
    decision = with_doubtful(decision, more, found.pool, against, thresholds, delays)
    decision = borne_out(decision, found.pool, against, thresholds, delays)
    foretold["augmented"] = foretold["baseline"]
    if decision.chosen.terms:
        foretold["augmented"] = foretold_by(engine, decision.chosen, fitted) | told[decision.chosen.terms]
    verdict = decision.verdict
    if verdict == "none" and (
        stopped or any(candidate.gain > thresholds.asked((candidate.term.effect.name,)) for candidate in found.lost)
    ):
        verdict = "unknown"  # not all was tried
    progress(0.93, "locating")
    return Diagnosis(
        fitted=fitted,
        heldout=heldout,
        temper=found.temper,
        noise_m=engine.noise_m,
        creep_m=engine.creep_m,
        baseline=decision.null,
        models=tuple(sorted(found.pool, key=lambda model: rating(model, thresholds))),
        chosen=decision.chosen,
        screened=found.screened,
        lost=found.lost,
        stopped=stopped,
        verdict=verdict,
        rivals=decision.rivals,
        misfit=decision.misfit,
        withdrawn=tuple(name for name in named.terms if name not in decision.chosen.terms),
        against=against.get((decision.chosen if decision.chosen.terms else named).terms, 0.0),
        rmse_m={
            label: {"fit": rmse_of(bundle, markers, fitted), "heldout": rmse_of(bundle, markers, heldout)}
            for label, markers in foretold.items()
        },
        heldout_markers_m={label: {name: markers[name] for name in heldout} for label, markers in foretold.items()},
        located=locate_forces(engine, decision.chosen.fit, engine.names),
        simulating_s=engine.simulating_s,
    )


def delays_measured(bundle: Bundle) -> frozenset[str]:
    """Effects of which the recordings show one without any simulation, if they do."""
    return DELAYS if is_late(bundle) else frozenset()
