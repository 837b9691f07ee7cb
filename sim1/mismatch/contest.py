"""Models of a bundle against each other: the baseline, one effect more, the leaders fitted again, and a second effect."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.effects import EFFECTS
from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.afar import Found, from_afar, unbent
from sim1.mismatch.decide import best_of, gain_of, null_of, rating, rivals_of
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import PROMISING, Fit, Tempers, fit, promised, temper_of
from sim1.mismatch.models import Model, calibrate, extended, joined, judged, widened, without
from sim1.mismatch.screen import Candidate
from sim1.mismatch.search import Unknowns
from sim1.mismatch.simplified import simplified
from sim1.mismatch.thresholds import Thresholds

SEARCHES = 3  # for effects, at most, from baselines of which each turned out to have been stuck
FINALISTS = 3  # models, the baseline among them, that are fitted again once the mesh's error is known at the best
AGAIN = 2  # iterations of that
LONGEST = 10  # iterations after which the leader's search ends, converged or not
NEAR, FAR = 270.0, 0.3  # nats, and of what the best gains: models further behind it are not fitted again
PARTNERS = 3  # second effects that are tried beside each
HINT = 30.0  # nats that slopes must promise of one: less than a name is worth, as on the coarser mesh they foretell to a quarter
HOPE = 0.75  # of the least that motion held out could still speak for, that they must promise, too
OTHERS = 2  # that gain by themselves and that no slopes promise anything of beside the best
FIRSTS = 3  # models that they are tried beside: the best one and its closest rivals

Progress = Callable[[float, str], None]


@dataclass(frozen=True, kw_only=True)
class Contest:
    """Every model that was fitted, the baseline among them, all with one temper and the same idea of the mesh's error."""

    pool: list[Model]
    temper: Tempers
    alone: tuple[Model, ...] = ()  # effects that gain by themselves, as they were first fitted, best first
    lost: tuple[Candidate, ...] = ()  # effects that promised something and that no simulation followed
    unfollowed: tuple[tuple[str, ...], ...] = ()  # effects together, worth a fit, that no simulation followed
    screened: tuple[Candidate, ...] = ()  # beside the baseline: every effect that the recordings could show
    unsharpened: str | None = (
        None  # why errors of mesh and step are known at the baseline alone; None: they were measured at the best, too
    )


def contest(
    engine: Engine,
    plain: Unknowns,
    names: tuple[str, ...],
    thresholds: Thresholds,
    progress: Progress,
    calibrated: Callable[[Fit], None],
) -> Contest:
    """Calibrate the baseline `plain` on the recordings `names`, tell it to `calibrated`, and try what could be missing from it."""
    what = "calibrating the baseline"
    progress(0.0, what)
    base = calibrate(engine, plain, np.zeros(plain.count), names, lambda share: progress(0.4 * share, what))
    calibrated(base)
    found = with_one_effect(engine, base, names, thresholds, lambda s, n: progress(0.4 + 0.3 * s, f"trying {n}"))
    if _promising(engine, found, thresholds):
        progress(0.7, "fitting the best again")
        found = to_the_end(engine, sharpened(engine, found, names, thresholds), names, thresholds)
    if _promising(engine, found, thresholds):
        best, temper = best_of(found.pool, thresholds), found.temper
        others = (*widened(engine, best, temper, names), *unbent(engine, best, temper, names))
        found = replace(found, pool=_best_of_each((*found.pool, *others)))
    if _promising(engine, found, thresholds):
        found = with_a_second(engine, found, names, thresholds, lambda s, n: progress(0.85 + 0.15 * s, f"trying {n}"))
        found = to_the_end(engine, found, names, thresholds)
    return found


def _promising(engine: Engine, found: Contest, thresholds: Thresholds) -> bool:
    gain = gain_of(found.pool, best_of(found.pool, thresholds), thresholds)
    return gain > PROMISING and not engine.patience.over


def with_one_effect(
    engine: Engine, base: Fit, names: tuple[str, ...], thresholds: Thresholds, progress: Progress
) -> Contest:
    """The baseline and each promising effect beside it.

    A baseline that turns out to have been stuck is a wrong place to look from: effects are then sought once more from the better one, and
    once more than that where it moves again. Else `none` would be said of a baseline beside which nothing was tried.
    """
    stuck_by, afar, kept = PROMISING, Found(), ()
    for _ in range(SEARCHES):
        if not afar.models:
            progress(0.0, "effects from afar")
            afar = from_afar(engine, base, base.temper, names)
        singles = extended(engine, base, base.temper, names, progress)
        kept = _best_of_each((*kept, *singles.models, *afar.models))  # what was fitted from the other, too
        pool = simplified(engine, [judged(base, base.temper), *kept], thresholds, names)
        better = null_of(pool).fit
        if engine.patience.over or base.cost - better.cost < stuck_by:
            break
        base = better
    alone = [one for one in pool if one.terms and gain_of(pool, one, thresholds) > PROMISING]
    return Contest(
        pool=pool,
        temper=base.temper,
        alone=tuple(sorted(alone, key=lambda one: rating(one, thresholds))),
        lost=singles.lost,
        unfollowed=_unfitted(afar.unfollowed, pool),
        screened=singles.screened,
    )


def _unfitted(asked: Iterable[tuple[str, ...]], pool: list[Model]) -> tuple[tuple[str, ...], ...]:
    """Each of these sets of effects once, but for those that some search fitted."""
    fitted = {model.terms for model in pool}
    return tuple(terms for terms in dict.fromkeys(asked) if terms not in fitted)


def _best_of_each(models: tuple[Model, ...]) -> list[Model]:
    """Of models with the same effects the one that fits best."""
    best: dict[tuple[str, ...], Model] = {}
    for model in models:
        if model.terms not in best or model.score < best[model.terms].score:
            best[model.terms] = model
    return list(best.values())


def sharpened(engine: Engine, found: Contest, names: tuple[str, ...], thresholds: Thresholds) -> Contest:
    """The leaders fitted again where the best one is: the mesh errs otherwise where an effect acts, for every model alike.

    As they were, by the errors at the baseline, where a mesh or a step finds no way at one of them (`unsharpened`).
    """
    try:
        with engine.aside(stay=True):
            return _sharpened(engine, found, names, thresholds)
    except NotConverged as error:
        return replace(found, unsharpened=str(error))


def _sharpened(engine: Engine, found: Contest, names: tuple[str, ...], thresholds: Thresholds) -> Contest:
    best = best_of(found.pool, thresholds)
    at = best.fit
    engine.refine(at.unknowns.world(at.z), names)
    looked = engine.soften(at.unknowns, at.z, names)
    finalists = sorted(found.pool, key=lambda model: (bool(model.terms), rating(model, thresholds)))[:FINALISTS]
    reach = max(NEAR, FAR * gain_of(found.pool, best, thresholds))
    pool = []
    for model in finalists:
        given = looked if model is best else None
        close = rating(model, thresholds) < rating(best, thresholds) + reach  # the others only to be compared
        most = AGAIN if close else 0
        again = fit(engine, model.fit.unknowns, model.fit.z, names, temper=found.temper, most=most, given=given)
        pool.append(judged(again, found.temper, model.variants))
    return _tempered(engine, replace(found, pool=simplified(engine, pool, thresholds, names)), names, thresholds)


def to_the_end(engine: Engine, found: Contest, names: tuple[str, ...], thresholds: Thresholds) -> Contest:
    """The leader searched until it has converged, and who by what its slopes promise may yet overtake it.

    What a strong effect that is half fitted leaves is large and differs from second to second, as if it were another effect.
    """
    pool, ended = list(found.pool), set()
    while not engine.patience.over:
        best = rating(best_of(pool, thresholds), thresholds)
        ahead = [
            place
            for place, one in enumerate(pool)
            if not (one.fit.converged or place in ended) and rating(one, thresholds) - promised(one.fit) <= best
        ]
        if not ahead:
            break
        place = min(ahead, key=lambda k: rating(pool[k], thresholds))
        ended.add(place)
        one = pool[place].fit
        given = one.residuals, one.slopes
        more = fit(engine, one.unknowns, one.z, names, temper=found.temper, most=LONGEST, given=given, exact=False)
        pool[place] = judged(more, found.temper, pool[place].variants)
    return _tempered(engine, replace(found, pool=pool), names, thresholds)


def _tempered(engine: Engine, found: Contest, names: tuple[str, ...], thresholds: Thresholds) -> Contest:
    """The same models by the temper of what the best one leaves: what it explains makes no neighbours alike any more."""
    temper = temper_of(engine, best_of(found.pool, thresholds).fit.residuals, names)
    return replace(found, pool=[judged(model.fit, temper, model.variants) for model in found.pool], temper=temper)


def with_a_second(
    engine: Engine, found: Contest, names: tuple[str, ...], thresholds: Thresholds, progress: Progress
) -> Contest:
    """Effects beside the best one: a baseline that imitates an effect is a bad place to look for another from.

    Beside its rivals too, else one of two that explain it alike would be chosen because the other was not taken further.
    """
    best = best_of(found.pool, thresholds)
    rivals = sorted(rivals_of(found.pool, best, thresholds), key=lambda model: rating(model, thresholds))
    firsts = (best, *rivals)[:FIRSTS]
    progress(0.0, f"effects from afar beside {best.terms[0]}")
    afar = from_afar(engine, best.fit, found.temper, names, best.variants)
    pairs, lost, unfollowed = [*afar.models], [], [*found.unfollowed, *afar.unfollowed]
    for number, first in enumerate(firsts):
        tried = extended(
            engine,
            first.fit,
            found.temper,
            names,
            lambda share, name, n=number, one=first: progress(
                (n + share) / len(firsts), f"{name} beside {one.terms[0]}"
            ),
            most=PARTNERS,
            least=hint_of(gain_of(found.pool, first, thresholds), thresholds),
            variants=first.variants,
        )
        pairs += tried.models
        lost += tried.lost
        unfollowed += [_both(first, candidate.term.effect.name) for candidate in tried.lost]
        there = {model.terms for model in pairs}
        others = with_others(
            engine,
            found,
            first,
            there,
            names,
            lambda name, n=number, one=first: progress((n + 1) / len(firsts), f"{name} beside {one.terms[0]}"),
        )
        pairs += [pair for pair in others.values() if pair]
        unfollowed += [terms for terms, pair in others.items() if not pair]
    pool = with_parts(engine, _best_of_each((*found.pool, *pairs)), thresholds, names)
    pool = simplified(engine, pool, thresholds, names)
    found = replace(found, pool=pool, lost=(*found.lost, *lost), unfollowed=_unfitted(unfollowed, pool))
    return _tempered(engine, found, names, thresholds)


def hint_of(gain: float, thresholds: Thresholds) -> float:
    """What slopes must promise of a second effect beside a first that gains so much, nats: one that can be no name is not fitted."""
    return max(HINT, HOPE * thresholds.doubtful * thresholds.second_share * gain)


def _both(first: Model, other: str) -> tuple[str, ...]:
    return tuple(sorted((*first.terms, other)))


def with_others(
    engine: Engine,
    found: Contest,
    first: Model,
    there: set[tuple[str, ...]],
    names: tuple[str, ...],
    trying: Callable[[str], None],
) -> dict[tuple[str, ...], Model | None]:
    """A single effect beside others that gain by themselves, but for pairs that are `there` and effects that hold one another.

    By both names; None where no simulation with both found its way.
    """
    if len(first.terms) > 1:
        return {}
    one, made = EFFECTS[first.terms[0]], {}
    by_name = {model.terms: model for model in found.alone}
    by_name |= {model.terms: model for model in found.pool if model.terms in by_name}  # fitted further
    others = [
        model
        for terms, model in by_name.items()
        if len({*first.terms, *terms}) == 2
        and one.widens != terms[0]
        and EFFECTS[terms[0]].widens != one.name
        and _both(first, terms[0]) not in there
    ]
    for other in others[:OTHERS]:
        if engine.patience.over:
            break
        trying(other.terms[0])
        made[_both(first, other.terms[0])] = joined(engine, first, other, found.temper, names)
    return made


def with_parts(engine: Engine, pool: list[Model], thresholds: Thresholds, names: tuple[str, ...]) -> list[Model]:
    """The pool with every single effect of the best pair, from where that arrived if it fits better so: what each adds to the other is asked of both."""
    best = best_of(pool, thresholds)
    if len(best.terms) < 2 or engine.patience.over:
        return pool
    parts = (without(engine, best, term, names) for term in range(len(best.terms)))
    return _best_of_each((*pool, *(part for part in parts if part is not None)))
