"""Effects that are sought from afar as well, as the way to them is not downhill.

Slopes at nothing tell a small offset of a clock. Where markers come late by a good part of a swing, the cost between rises, and a search from
nothing gets stuck near it, with a baseline that was bent to imitate the delay. So a few values far off are simulated, from the baseline as it was
fitted and as it was before any fit, and the best one is the start of a calibration of its own.

What the fabric can imitate nearly whole shows in slopes at nothing as next to nothing: cloth that clings to a table slides as if its friction were
higher, and the way from that friction to the two together is narrow and bent. So the fabric is relieved of what the effect would do in its place.
That is looked at on the working mesh, as a coarser one errs by more than there is to see.
"""

from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.engine import Engine
from sim1.mismatch.excess import mean_square
from sim1.mismatch.fit import Fit, Start, Tempers, cheapest, cost_at, fit
from sim1.mismatch.models import Model, calibrate, judged
from sim1.mismatch.screen import possible, site_of
from sim1.mismatch.search import Term

EXCESS = 2.0  # mean squared residual of a baseline from which it is worth it, but for what hides in it
STEPS = 2  # of the search from where that ends
CLEAR = 5.0  # nats by which what hides in the fabric must cost less than the baseline before it is fitted
MORE = 8  # steps of that


@dataclass(frozen=True, kw_only=True)
class Found:
    """What was sought from afar."""

    models: tuple[Model, ...] = ()  # with one effect more
    unfollowed: tuple[
        tuple[str, ...], ...
    ] = ()  # effects together that cost less somewhere and that no search followed from there


def from_afar(engine: Engine, base: Fit, temper: Tempers, names: tuple[str, ...], variants: int = 1) -> Found:
    """One effect more, found from values far from nothing.

    Where `base` leaves little, only effects that hide in the fabric are sought. `variants`: starts that the shapes of `base` were chosen from.
    """
    if engine.patience.over:  # meshes may not be what they were when the sheet's rest was found
        return Found()
    world, much = base.unknowns.world(base.z), mean_square(base) >= EXCESS
    base, models, unfollowed = replace(base, temper=temper), [], []
    for effect in possible(site_of(engine, world), base.unknowns.terms):
        hides = bool(effect.afar) and bool(effect.relieves(world, effect.afar[0]))
        if not (effect.afar and (much or hides)) or engine.patience.over:
            continue
        try:
            one = (_uncovered if hides else _fitted)(engine, base, Term.of(effect), names)
        except NotConverged:
            unfollowed.append(tuple(sorted((*(term.effect.name for term in base.unknowns.terms), effect.name))))
            continue
        if one is not None:
            models.append(judged(one, temper, variants * len(effect.afar)))
    return Found(models=tuple(models), unfollowed=tuple(unfollowed))


def _fitted(engine: Engine, base: Fit, term: Term, names: tuple[str, ...]) -> Fit | None:
    before = np.concatenate([np.zeros(len(base.nominal_z)), base.z[len(base.nominal_z) :]])
    starts = [_start(base, term, fabric, values) for values in term.effect.afar for fabric in (base.z, before)]
    with engine.aside():
        engine.finer = max(engine.finest - 1, 0)  # where a calibration begins, and several times as fast
        least = cost_at(engine, base.unknowns, base.z, names, base.temper)
        start = cheapest(engine, starts, least, names, base.temper)
    return _anew(engine, start, base.temper, names) if start else None


def _uncovered(engine: Engine, base: Fit, term: Term, names: tuple[str, ...]) -> Fit | None:
    starts = [_start(base, term, relieved(base, term, values), values) for values in term.effect.afar]
    start = cheapest(engine, starts, base.cost - CLEAR, names, base.temper)
    return fit(engine, *start, names, temper=base.temper, most=MORE) if start else None


def unbent(engine: Engine, best: Model, temper: Tempers, names: tuple[str, ...]) -> tuple[Model, ...]:
    """The same effects from a fabric as it was before any fit, where the best model leaves much; none if no simulation follows.

    The fabric that it set out from was bent to imitate them, and a search need not find the way back.
    """
    if not best.terms or engine.patience.over or mean_square(best.fit) < EXCESS:
        return ()
    fitted = best.fit
    z = np.concatenate([np.zeros(len(fitted.nominal_z)), fitted.z[len(fitted.nominal_z) :]])
    try:
        again = _anew(engine, (fitted.unknowns, z), temper, names)
    except NotConverged:
        return ()
    return (judged(again, temper, best.variants),)


def _anew(engine: Engine, start: Start, temper: Tempers, names: tuple[str, ...]) -> Fit:
    """Calibrated from there on the coarser mesh, then fitted on the working one by the idea of what that gets wrong that all models have."""
    with engine.aside():
        engine.finer = max(engine.finest - 1, 0)
        alone = calibrate(engine, *start, names, lambda share: None)
    return fit(engine, alone.unknowns, alone.z, names, temper=temper, most=STEPS)


def _start(base: Fit, term: Term, z: np.ndarray, values: dict[str, float]) -> Start:
    """The term at `values` beside the rest at `z`."""
    far = [one.z(values.get(one.name, one.centre)) for one in term.coefficients]
    return base.unknowns.with_terms(*base.unknowns.terms, term), np.concatenate([z, far])


def relieved(base: Fit, term: Term, values: dict[str, float]) -> np.ndarray:
    """Z (P,) of `base`, its fabric without what the term would do in its place at such `values`."""
    shares = term.effect.relieves(base.unknowns.world(base.z), values)
    z = base.z.copy()
    for place, one in enumerate(base.unknowns.nominal):
        if one.name in shares:
            z[place] = one.z(shares[one.name] * one.value(float(z[place])))
    return z
