"""The whole diagnosis of a bundle: measure, calibrate, locate, name, model, decide."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.assimilate import Located, locate_forces
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit, Tempers, fit, temper_of
from sim1.mismatch.models import Model, Tried, calibrate, extended, judged
from sim1.mismatch.patience import Patience
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import baseline
from sim1.recording.bundle import Bundle
from sim1.stage import BadInput

FINALISTS = 3  # models, the baseline among them, that are fitted again once the mesh's error is known at the best
AGAIN = 2  # iterations of that
NEAR, FAR = 3.0, 0.3  # of a threshold, and of what the best gains: models further behind it are not fitted again
WORTH_MORE = 0.5  # share of a threshold from which more effort is spent


@dataclass(frozen=True, kw_only=True)
class Thresholds:
    """When a difference counts, in nats of evidence. Chosen on a handful of bundles; not yet calibrated on nulls."""

    named: float = 45.0  # that an effect must gain over the baseline
    second: float = 25.0  # that another must gain over the first
    second_share: float = 0.03  # and in units of the first's gain: another formula or mesh leaves that much unexplained
    margin: float = 8.0  # over the runner-up
    margin_share: float = 0.002  # and in units of its own gain
    per_term: float = 2.0  # that every effect costs: there are two dozen to choose from
    explained: float = 0.5  # of the baseline's excess over noise and mesh that a named model must explain
    misfit: float = 1.35  # mean squared residual, in units of its variance, from which something is taken to be missing


THRESHOLDS = Thresholds()


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """What was found, before it is put into words."""

    fitted: tuple[str, ...]
    heldout: tuple[str, ...]
    temper: Tempers
    noise_m: float
    baseline: Model
    models: tuple[Model, ...]  # every model that was fitted, best first, the baseline among them
    chosen: Model
    lost: tuple[Candidate, ...]  # effects that promised something and that no simulation followed
    stopped: bool  # before all was tried
    verdict: str
    rivals: tuple[Model, ...]  # that explain it about as well
    misfit: dict[str, float]  # mean squared residual of baseline and chosen on what was fitted
    rmse_m: dict[str, dict[str, float]]
    heldout_markers_m: dict[str, dict[str, np.ndarray]]  # baseline, augmented: recording -> (N, M, 3)
    located: Located  # against the baseline
    simulating_s: float  # of the time that it took


def rating(model: Model, thresholds: Thresholds) -> float:
    """Score with the price of its coefficients; smaller is better."""
    return model.score + thresholds.per_term * len(model.terms)


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


def gain_of(pool: list[Model], model: Model, thresholds: Thresholds) -> float:
    """What a model gains over the baseline, nats."""
    null = next(one for one in pool if not one.terms)
    return rating(null, thresholds) - rating(model, thresholds)


def _diagnose(
    engine: Engine, bundle: Bundle, thresholds: Thresholds, progress: Callable[[float, str], None]
) -> Diagnosis:
    plain, heldout = baseline(bundle), (held_out(bundle),)
    everything = engine.names
    fitted = tuple(name for name in everything if name not in heldout)
    what = "calibrating the baseline"
    progress(0.02, what)
    base = calibrate(engine, plain, np.zeros(plain.count), fitted, lambda share: progress(0.02 + 0.28 * share, what))
    temper = base.temper
    singles = extended(engine, base, temper, fitted, lambda s, n: progress(0.3 + 0.25 * s, f"trying {n}"))
    pool = [judged(base, temper), *singles.models]
    pool = _simplified(engine, pool, thresholds, fitted)
    best = min(pool, key=lambda model: rating(model, thresholds))
    if gain_of(pool, best, thresholds) > WORTH_MORE * thresholds.named and not engine.patience.over:
        progress(0.55, "fitting the best again")
        # The mesh errs otherwise where the effect acts: measured anew there, for every model alike.
        at, world = best.fit, best.fit.unknowns.world(best.fit.z)
        engine.refine(world, fitted)
        looked = engine.soften(at.unknowns, at.z, fitted)
        finalists = sorted(pool, key=lambda m: (bool(m.terms), rating(m, thresholds)))[:FINALISTS]
        pool = []
        reach = max(NEAR * thresholds.named, FAR * gain_of(finalists, best, thresholds))
        for model in finalists:
            given = looked if model is best else None
            close = rating(model, thresholds) < rating(best, thresholds) + reach  # the others only to be compared
            most = AGAIN if close else 0
            again = fit(engine, model.fit.unknowns, model.fit.z, fitted, temper=temper, most=most, given=given)
            pool.append(judged(again, temper, model.variants))
        pool = _simplified(engine, pool, thresholds, fitted)
        best = min(pool, key=lambda model: rating(model, thresholds))
        temper = temper_of(engine, best.fit.residuals, fitted)
        pool = [judged(model.fit, temper, model.variants) for model in pool]
        best = min(pool, key=lambda model: rating(model, thresholds))
    gain = gain_of(pool, best, thresholds)
    pairs = Tried()
    if gain > WORTH_MORE * thresholds.named and not engine.patience.over:
        # A baseline that imitates the effect is a bad place to look for a second one from: look from the best single.
        pairs = extended(
            engine,
            best.fit,
            temper,
            fitted,
            lambda s, n: progress(0.65 + 0.15 * s, f"trying {n} beside {best.terms[0]}"),
            most=3,
            least=WORTH_MORE * max(thresholds.second, thresholds.second_share * gain),
            variants=best.variants,
        )
        pool = _simplified(engine, [*pool, *pairs.models], thresholds, fitted)
    ranked = sorted(pool, key=lambda model: rating(model, thresholds))
    null = next(model for model in pool if not model.terms)
    stopped = engine.patience.over
    verdict, chosen, rivals, misfit = decide(null, ranked, thresholds)
    lost = (*singles.lost, *pairs.lost)
    if verdict == "none" and (stopped or any(candidate.gain > thresholds.named for candidate in lost)):
        verdict = "unknown"  # not all was tried
    progress(0.8, "checking on motion held out")
    rmse, shown = {}, {}
    for label, model in (("baseline", null), ("augmented", chosen)):
        if label == "augmented" and chosen is null:
            rmse[label], shown[label] = rmse["baseline"], shown["baseline"]
            continue
        markers = engine.foretell(model.fit.unknowns.world(model.fit.z), everything)
        shown[label] = {name: markers[name] for name in heldout}
        rmse[label] = {"fit": rmse_of(bundle, markers, fitted), "heldout": rmse_of(bundle, markers, heldout)}
    progress(0.93, "locating")
    located = locate_forces(engine, null.fit.unknowns.world(null.fit.z), everything)
    return Diagnosis(
        fitted=fitted,
        heldout=heldout,
        temper=temper,
        noise_m=engine.noise_m,
        baseline=null,
        models=tuple(ranked),
        chosen=chosen,
        lost=lost,
        stopped=stopped,
        verdict=verdict,
        rivals=tuple(rivals),
        misfit=misfit,
        rmse_m=rmse,
        heldout_markers_m=shown,
        located=located,
        simulating_s=engine.simulating_s,
    )


def _simplified(engine: Engine, pool: list[Model], thresholds: Thresholds, names: tuple[str, ...]) -> list[Model]:
    """The pool with models that the best contains fitted from where the best arrived, if that is better.

    A search that stopped on the wrong side of a fold would else make the next coefficient look like physics.
    """
    best = min(pool, key=lambda model: rating(model, thresholds))
    kept = []
    for model in pool:
        inside = set(model.terms) < set(best.terms)
        kept.append(_from_there(engine, model, best, names) if inside and not engine.patience.over else model)
    return kept


def _from_there(engine: Engine, model: Model, other: Model, names: tuple[str, ...]) -> Model:
    count = len(model.fit.unknowns.nominal)
    start = np.concatenate([other.fit.z[:count], model.fit.z[count:]])
    try:
        found = fit(engine, model.fit.unknowns, start, names, temper=model.fit.temper, most=AGAIN)
    except NotConverged:
        return model
    again = judged(found, model.fit.temper, model.variants)
    return again if again.score < model.score else model


def held_out(bundle: Bundle) -> str:
    """The recording that no fit sees: the one whose motion, by the drives alone, is most like another's."""
    features = {}
    for recording in bundle.recordings:
        rows = []
        for hold in recording.holds:
            track = recording.drives[hold.drive]
            time = np.linspace(track.time_s[0], track.time_s[-1], 200)
            place = np.stack([np.interp(time, track.time_s, track.position_m[:, k]) for k in range(3)], axis=1)
            speed = np.gradient(place, time, axis=0)
            rows.append(np.concatenate([np.std(place, axis=0), 0.2 * np.std(speed, axis=0), [0.2 * place[:, 2].min()]]))
        features[recording.name] = np.mean(rows, axis=0)
    names = list(features)
    nearest = {a: min(float(np.linalg.norm(features[a] - features[b])) for b in names if b != a) for a in names}
    return min(reversed(names), key=lambda name: nearest[name])


def rmse_of(bundle: Bundle, markers: dict[str, np.ndarray], names: tuple[str, ...]) -> float:
    """Root mean square difference per coordinate, m."""
    parts = [(markers[r.name] - r.markers_m)[r.seen].ravel() for r in bundle.recordings if r.name in names]
    return float(np.sqrt(np.square(np.concatenate(parts)).mean()))


def mean_square(fit: Fit) -> float:
    """Mean squared residual, gross errors capped, in units of its variance."""
    values = np.concatenate([fit.residuals[name] for name in fit.names])
    return float(np.mean(np.minimum(values**2, 25.0)))


def _contained(small: tuple[str, ...], large: tuple[str, ...]) -> bool:
    """Whether one model is the other with less: wind brings drag with it."""
    inside = {"air_drag"} if "wind" in large else set()
    return small != large and set(small) <= set(large) | inside


def decide(
    null: Model, ranked: list[Model], thresholds: Thresholds
) -> tuple[str, Model, list[Model], dict[str, float]]:
    """Verdict, chosen model, rivals and misfits."""
    best = ranked[0]
    gain = {id(model): rating(null, thresholds) - rating(model, thresholds) for model in ranked}
    before = mean_square(null.fit)
    misfit = {"baseline": before}
    if not best.terms or gain[id(best)] < thresholds.named:
        misfit["chosen"] = before
        return ("none" if before < thresholds.misfit else "unknown"), null, [], misfit
    # The simplest model within reach of the best: fewer effects, or a family that the best one's contains.
    for model in ranked:
        simpler = len(model.terms) < len(best.terms) or _contained(model.terms, best.terms)
        reach = max(thresholds.second, thresholds.second_share * gain[id(model)])
        if model.terms and simpler and gain[id(best)] - gain[id(model)] < reach:
            best = model
    close = max(thresholds.margin, thresholds.margin_share * gain[id(best)])
    after = mean_square(best.fit)
    misfit["chosen"] = after
    floor = 1.0
    explained = (before - after) / max(before - floor, 1e-9)
    rivals = [
        model
        for model in ranked
        if model.terms
        and model is not best
        and not set(best.terms) <= set(model.terms)
        and not _contained(best.terms, model.terms)
        and len(model.terms) <= len(best.terms)
        and gain[id(best)] - gain[id(model)] < close
    ]
    if after > thresholds.misfit and explained < thresholds.explained:
        return "unknown", best, rivals, misfit
    return ("ambiguous" if rivals else "named"), best, rivals, misfit
