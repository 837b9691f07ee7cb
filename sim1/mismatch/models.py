"""Fit the baseline to convergence, then the models that could replace it; keep them comparable."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.afresh import afresh
from sim1.mismatch.elsewhere import elsewhere
from sim1.mismatch.engine import FOLLOW_HZ, Engine
from sim1.mismatch.fit import CONVERGED, PROMISING, Fit, Tempers, fit, promised, temper_of
from sim1.mismatch.scout import further, scouted
from sim1.mismatch.screen import Candidate, screen, site_of
from sim1.mismatch.search import Term, Unknowns

# Passes of a calibration: whether on the working mesh, and how fast markers are followed. A short lead finds the way past the folds
# on which a long one gets stuck; a long lead shows more of what is missing, above all of what acts slowly.
PASSES = ((False, 2.0), (True, 2.0), (True, FOLLOW_HZ))
SHORTLIST = 6
MORE = 4  # iterations of the leaders, after a first look at all
LEADERS = 3
HOPELESS = 60.0  # nats by which a candidate's promise may lie behind the leader's
ALIKE = 0.5  # of what screening says of the leader: who has that is taken further however far behind
ROUGH = 0.01  # share of the cost below which the search on the coarser mesh does not go on
WORSE = 20.0  # nats by which a first look may be worse than the baseline and is still a place to go on from
WORTH = 2.0  # nats that a candidate must promise to be fitted
FIRST_TEMPER = 8.0  # before any residual is known


@dataclass(frozen=True, kw_only=True)
class Model:
    """A fitted model with its evidence."""

    terms: tuple[str, ...]  # names of the effects, sorted
    fit: Fit
    variants: int  # starts that its shapes were chosen from

    @property
    def score(self) -> float:
        """Negative log evidence (Laplace): the cost of the fit and the share of the prior that the data leave; smaller is better."""
        _, size = np.linalg.slogdet(self.fit.covariance)
        return self.fit.cost - 0.5 * float(size) + float(np.log(self.variants))


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What became of the effects that a model could be extended by."""

    models: tuple[Model, ...] = ()  # best first
    lost: tuple[Candidate, ...] = ()  # promising, and no simulation with them found its way
    screened: tuple[Candidate, ...] = ()  # every effect that the recordings could show


def calibrate(
    engine: Engine,
    unknowns: Unknowns,
    z: np.ndarray,
    names: tuple[str, ...],
    progress: Callable[[float], None],
) -> Fit:
    """Fit and measure anew what mesh and step get wrong, in turn, by `PASSES`."""
    temper, found = dict.fromkeys(names, FIRST_TEMPER), None
    try:
        for number, (working, follow_hz) in enumerate(PASSES):
            engine.finer = engine.finest if working else max(engine.finest - 1, 0)
            engine.follow_hz = follow_hz
            if not engine.patience.over:
                engine.refine(unknowns.world(z), names)
            looked = engine.soften(unknowns, z, names)
            found = fit(
                engine,
                unknowns,
                z,
                names,
                temper=temper,
                enough=CONVERGED if number == len(PASSES) - 1 else ROUGH,
                given=looked,
                settle=number == len(PASSES) - 1,
                progress=lambda share, n=number: progress((n + share) / len(PASSES)),
            )
            z, temper = found.z, temper_of(engine, found.residuals, names)
            if engine.patience.over:
                break
    finally:  # as models are compared, also where it was stopped early or found no way
        engine.finer, engine.follow_hz = engine.finest, FOLLOW_HZ
    return replace(found, temper=temper)


def judged(found: Fit, temper: Tempers, variants: int = 1) -> Model:
    """A fit as a model among others, all with one temper."""
    found = replace(found, temper=temper)
    return Model(
        terms=tuple(sorted(term.effect.name for term in found.unknowns.terms)),
        fit=found,
        variants=variants,
    )


def extended(
    engine: Engine,
    base: Fit,
    temper: Tempers,
    names: tuple[str, ...],
    progress: Callable[[float, str], None],
    most: int = SHORTLIST,
    least: float = WORTH,
    variants: int = 1,
) -> Tried:
    """`base` with each of the most promising effects added, fitted."""
    if engine.patience.over:
        return Tried()
    site = site_of(engine, base.unknowns.world(base.z))
    base = replace(base, temper=temper)
    screened = tuple(screen(engine, base, site, names))
    worth = [candidate for candidate in screened if candidate.gain > least][:most]
    models, tried, lost = [], [], []
    for number, candidate in enumerate(worth):  # a look at all where the screening sends them, more for those who lead
        if engine.patience.over:
            break
        progress(0.5 * number / len(worth), candidate.term.effect.name)
        terms = (*base.unknowns.terms, candidate.term)
        model = _looked_at(engine, base, terms, candidate.start, temper, names, variants * candidate.variants)
        if model is None:
            lost.append(candidate)
        else:
            models.append(model)
            tried.append(candidate)
    leaders = leading(models, tried)
    promising = bool(leaders) and tried[leaders[0]].gain > PROMISING
    if promising:
        progress(0.5, ", ".join(models[leaders[0]].terms))
    looks = [models[k].fit for k in leaders]
    starts = scouted(engine, base, looks, [tried[k] for k in leaders]) if promising else [None] * len(leaders)
    for number, (k, start) in enumerate(zip(leaders, starts, strict=True)):
        model = models[k]
        if start and start.gain < least:  # searched to the end on the coarser mesh: on the finer it would be no other
            continue
        progress(0.5 + 0.5 * number / LEADERS, ", ".join(model.terms))
        more = further(engine, model.fit, start, MORE)
        more = elsewhere(engine, base, afresh(engine, base, more, tried[k]), tried[k], site)
        models[k] = judged(more, temper, model.variants)
    return Tried(models=tuple(sorted(models, key=lambda model: model.score)), lost=tuple(lost), screened=screened)


def leading(models: list[Model], tried: list[Candidate]) -> list[int]:
    """Places of the models that are taken further after a first look, best first; `tried` is what screening said of each.

    Who promises as much as the leader, or did so on screen: a look that stopped on the way says little of where it leads.
    """
    promises = [model.score - promised(model.fit) for model in models]
    ahead = sorted(range(len(models)), key=lambda k: promises[k])[:LEADERS]
    return [
        k for k in ahead if promises[k] < promises[ahead[0]] + HOPELESS or tried[k].gain > ALIKE * tried[ahead[0]].gain
    ]


def widened(engine: Engine, model: Model, temper: Tempers, names: tuple[str, ...]) -> list[Model]:
    """The model with an effect in place of one that it widens, from where that was: wind from the drag of still air.

    From still air the way to a weak stream is downhill; from a stream of another direction or speed it may not be.
    """
    known, z, made = model.fit.unknowns, model.fit.z, []
    for place, term in enumerate(known.terms):
        old = known.part(place)
        for effect in (e for e in EFFECTS.values() if e.widens == term.effect.name):
            wider = Term.of(effect)
            before = known.values(place, z)
            own = [c.z(before[c.name]) if c.name in before else 0.0 for c in wider.coefficients]
            start = np.concatenate([z[: old.start], own, z[old.stop :]])
            terms = (*known.terms[:place], wider, *known.terms[place + 1 :])
            try:
                found = fit(engine, replace(known, terms=terms), start, names, temper=temper, most=MORE)
            except NotConverged:
                continue
            made.append(judged(found, temper, model.variants))
    return made


def joined(engine: Engine, model: Model, other: Model, temper: Tempers, names: tuple[str, ...]) -> Model | None:
    """The effects of both, from where `model` arrived and with `other`'s as that has them; None where no simulation finds its way.

    What both imitate, places of grips say, beside one of them promises nothing of the other: it has to come in while they change.
    """
    base, fitted = replace(model.fit, temper=temper), other.fit
    terms = (*base.unknowns.terms, *fitted.unknowns.terms)
    start = np.concatenate([base.z, fitted.z[len(fitted.unknowns.nominal) :]])
    looked = _looked_at(engine, base, terms, start, temper, names, model.variants * other.variants)
    if looked is None:
        return None
    given = (looked.fit.residuals, looked.fit.slopes)
    found = fit(engine, looked.fit.unknowns, looked.fit.z, names, temper=temper, most=MORE, given=given, exact=False)
    return judged(found, temper, looked.variants)


def without(engine: Engine, model: Model, place: int, names: tuple[str, ...]) -> Model | None:
    """The model without one of its effects, from where it was; None where no simulation finds its way."""
    known, z = model.fit.unknowns, model.fit.z
    own = known.part(place)
    terms = (*known.terms[:place], *known.terms[place + 1 :])
    start = np.concatenate([z[: own.start], z[own.stop :]])
    try:
        found = fit(engine, replace(known, terms=terms), start, names, temper=model.fit.temper, most=MORE)
    except NotConverged:
        return None
    return judged(found, model.fit.temper, model.variants)


def _looked_at(
    engine: Engine,
    base: Fit,
    terms: tuple[Term, ...],
    start: np.ndarray,
    temper: Tempers,
    names: tuple[str, ...],
    variants: int,
) -> Model | None:
    """A first look from where the screening sends it: only slopes of the new coefficients are measured."""
    unknowns = base.unknowns.with_terms(*terms)
    count = len(base.z)
    z = np.concatenate([base.z, np.zeros(unknowns.count - count)])
    low, high = unknowns.bounds()
    found = None
    for share in (1.0, 0.3, 0.05):  # a linear forecast may promise more than the sheet can follow
        there = np.clip(z + share * (start - z), low, high)
        try:
            residuals, new = engine.slopes(unknowns, there, names, first=count)
        except NotConverged:
            continue
        slopes = {name: np.hstack([base.slopes[name], new[name]]) for name in names}
        found = fit(engine, unknowns, there, names, temper=temper, most=0, given=(residuals, slopes), settle=False)
        if found.cost < base.cost + WORSE:
            break
    return judged(found, temper, variants) if found else None
