"""The whole diagnosis of a bundle: measure, calibrate, locate, name, model, decide."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sim1.cloth.effects import EFFECTS
from sim1.mismatch.assimilate import Located, locate_forces
from sim1.mismatch.borne_out import parts_of
from sim1.mismatch.decide import rating
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit, Tempers
from sim1.mismatch.foretold import ByTerms, Foretold, foretold_by
from sim1.mismatch.heldout import rmse_of
from sim1.mismatch.models import Model
from sim1.mismatch.noise import frame_noise
from sim1.mismatch.patience import Patience
from sim1.mismatch.remarks import (
    by_others,
    explains_heldout,
    not_asked,
    not_followed,
    not_foretold,
    not_set_apart,
    not_sharpened,
    off_priors,
    vote,
)
from sim1.mismatch.rounds import rounds
from sim1.mismatch.screen import Candidate
from sim1.mismatch.thresholds import THRESHOLDS, Thresholds
from sim1.recording.bundle import Bundle
from sim1.recording.lateness import is_late
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """What was found, before it is put into words."""

    fitted: tuple[str, ...]
    heldout: tuple[str, ...]
    temper: Tempers
    noise_m: float  # of a marker's coordinate in one frame
    creep_m: float  # of markers over the cloth; 0: none seen
    baseline: Model
    models: tuple[Model, ...]  # every model that was fitted, best first, the baseline among them
    # Where fits name nothing: those that motion held out was asked about, with it added to what they were fitted to.
    heard: tuple[Model, ...]
    chosen: Model
    measured: frozenset[str]  # effects that the recordings show without any model of the cloth
    screened: tuple[Candidate, ...]  # beside the baseline: every effect that the recordings could show
    lost: tuple[Candidate, ...]  # effects that promised something and that no simulation followed
    stopped: bool  # before all was tried
    verdict: str
    rivals: tuple[Model, ...]  # that explain it about as well
    misfit: dict[str, float]  # mean squared residual of baseline and chosen on what was fitted
    left_heldout: float | None  # of the chosen on what was not, as `Round.left`
    spoken_for: tuple[str, ...]  # names that fits left in doubt and motion held out decided for
    withdrawn: tuple[str, ...]  # names that motion held out took back
    # Nats by which motion held out is less likely with what was named, or withdrawn; None: not known.
    against: float | None
    rmse_m: dict[str, dict[str, float | None]]  # None: not all of the motion can be simulated
    # baseline, augmented: recording -> (N, M, 3), where it can be simulated
    heldout_markers_m: dict[str, dict[str, np.ndarray]]
    # Error held out of what was chosen without each of its effects, where that was asked.
    heldout_without_m: dict[str, float | None]
    located: Located  # what the chosen model has and the baseline has not; what is missing, if nothing was chosen
    remarks: tuple[str, ...]  # what could not be computed, and what contradicts what was stated
    simulating_s: float  # of the time that it took


def diagnose(
    bundle: Bundle,
    *,
    thresholds: Thresholds = THRESHOLDS,
    progress: Callable[[float, str], None] = lambda s, w: None,
    patience: Patience | None = None,
    calibrated: Callable[[Fit], None] = lambda base: None,
    kind: type[Engine] = Engine,
) -> Diagnosis:
    """Diagnose a bundle; what is known when `patience` ends is reported.

    `calibrated` is told the baseline as soon as it is calibrated: it may yet be fitted further. `kind`: of engine, for those that leave
    something out to learn what it is worth.

    Raises:
        BadInput: fewer than two recordings, or markers whose noise nobody knows (`noise_of_blocks_m`).
        NotConverged: a recording that the baseline cannot follow.
    """
    if len(bundle.recordings) < 2:
        raise BadInput(
            f"{bundle.folder / 'bundle.yaml'}: {len(bundle.recordings)} recording; a diagnosis needs two or more, one of them to test what the others taught"
        )
    with kind(bundle, patience=patience) as engine:
        return _diagnose(engine, bundle, thresholds, progress, calibrated)


def _diagnose(
    engine: Engine,
    bundle: Bundle,
    thresholds: Thresholds,
    progress: Callable[[float, str], None],
    calibrated: Callable[[Fit], None],
) -> Diagnosis:
    delays = delays_measured(bundle)
    tried = rounds(
        engine, bundle, thresholds, delays, lambda share, what: progress(0.02 + 0.78 * share, what), calibrated
    )
    fitted, heldout, found, judged = tried.last.fitted, tried.last.heldout, tried.last.found, tried.last.judged
    stopped = tried.stopped
    decision, named = judged.decision, judged.named
    foretold = {"baseline": foretold_by(engine, decision.null, engine.names)}
    told = {(): foretold["baseline"].of(heldout)}  # by effects
    led = decision.chosen if decision.chosen.terms else named
    for one in (led, *([] if stopped else parts_of(found.pool, led))):
        told[one.terms] = told.get(one.terms) or foretold_by(engine, one, heldout)
    foretold["augmented"] = foretold["baseline"]
    if decision.chosen.terms:
        foretold["augmented"] = foretold_by(engine, decision.chosen, fitted).and_of(told[decision.chosen.terms])
    verdict = as_far_as_tried(decision.verdict, stopped, found.lost, thresholds)
    noise = frame_noise(bundle, [engine.observed(name) for name in engine.names])
    progress(0.93, "locating")
    located = locate_forces(engine, decision.chosen.fit, engine.names)
    without_m = _without_each(bundle, decision.chosen.terms, told, heldout)
    return Diagnosis(
        fitted=fitted,
        heldout=heldout,
        temper=found.temper,
        noise_m=noise.std_m,
        creep_m=engine.creep_m,
        baseline=decision.null,
        models=tuple(sorted(found.pool, key=lambda model: rating(model, thresholds))),
        heard=judged.hopeful,
        chosen=decision.chosen,
        measured=delays,
        screened=found.screened,
        lost=found.lost,
        stopped=stopped,
        verdict=verdict,
        rivals=decision.rivals,
        misfit=decision.misfit,
        left_heldout=tried.last.left,
        spoken_for=judged.spoken_for,
        withdrawn=judged.withdrawn,
        against=judged.against,
        rmse_m={
            label: {"fit": _error_m(bundle, one, fitted), "heldout": _error_m(bundle, one, heldout)}
            for label, one in foretold.items()
        },
        heldout_markers_m={label: one.of(heldout).markers_m for label, one in foretold.items()},
        heldout_without_m=without_m,
        located=located,
        remarks=(
            *([noise.remark] if noise.remark else []),
            *off_priors(decision.chosen.fit),
            vote(heldout, judged),
            *by_others(judged),
            *explains_heldout(tried, thresholds),
            *not_foretold(foretold),
            *(not_followed(terms) for terms in found.unfollowed),
            *([not_sharpened(found.unsharpened)] if found.unsharpened else []),
            *(not_asked(terms, why) for terms, why in judged.heard.unasked.items()),
            *(not_set_apart(name) for name, error_m in without_m.items() if error_m is None),
            *(f"no force is located in {name}: {why}" for name, why in located.lost.items()),
        ),
        simulating_s=engine.simulating_s,
    )


def as_far_as_tried(verdict: str, stopped: bool, lost: tuple[Candidate, ...], thresholds: Thresholds) -> str:
    """`unknown` in place of `none` where the search ended early, or no simulation followed something that promised a name."""
    untried = stopped or any(candidate.gain > thresholds.named for candidate in lost)
    return "unknown" if verdict == "none" and untried else verdict


def _error_m(bundle: Bundle, told: Foretold, names: tuple[str, ...]) -> float | None:
    """Root mean square error per coordinate; None where one of the recordings could not be simulated: of fewer it is another figure."""
    return None if told.of(names).lost else rmse_of(bundle, told.markers_m, names)


def _without_each(
    bundle: Bundle, terms: tuple[str, ...], told: ByTerms, heldout: tuple[str, ...]
) -> dict[str, float | None]:
    """Error of the model with all effects but one, by that one; None: there is none that was fitted and foretold to the end."""
    rest = {name: told.get(tuple(one for one in terms if one != name)) for name in terms}
    return {name: one and _error_m(bundle, one, heldout) for name, one in rest.items()}


def delays_measured(bundle: Bundle) -> frozenset[str]:
    """Effects of which the recordings show one without any simulation, if they do."""
    return frozenset(name for name, effect in EFFECTS.items() if effect.delays) if is_late(bundle) else frozenset()
