"""Shortlist missing physics: the fingerprint of every effect, with what the baseline could imitate of it taken out.

Rao's score test for an omitted term: one twin per candidate tells how every marker would move; the gain of adding it, to second
order and with all other coefficients free to adjust, needs no further simulation. It only shortlists.
"""

from dataclasses import dataclass, replace

import numpy as np

from sim1.cloth.effects import EFFECTS, Effect, Site
from sim1.cloth.precise.simulate import NotConverged
from sim1.cloth.precise.world import World
from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit, bounded_step, shortened, weights
from sim1.mismatch.search import Term


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """A term that could be added, and what that is expected to gain."""

    term: Term
    gain: float  # nats, at the strength that is best to second order
    start: np.ndarray  # z of the widened model
    variants: int  # of which this is the best
    information: tuple[
        float, ...
    ] = ()  # by strength: curvature of the cost that no coefficient of the model can imitate; median of the variants that show


def site_of(engine: Engine, world: World) -> Site:
    """Where effects could act in this bundle, beside what `world` has."""
    bundle = engine.bundle
    stage = next(iter(engine.stages.values()))
    points = stage.scene.sheet.material_m
    weight = world.area_density_kg_m2 * stage.scene.sheet.face_area_m2.sum() * 9.81
    grips = max(len(recording.holds) for recording in bundle.recordings)
    curvature = 20.0
    bends = []
    for one in engine.stages.values():
        if one.rest_m is not None:
            stencils = one.scene.sheet.stencils
            second = np.add.reduceat(
                stencils.second[:, :2, None] * one.rest_m[stencils.node][:, None], stencils.first[:-1], axis=0
            )
            bends.append(np.linalg.norm(second, axis=-1).max(1))
    if bends:
        curvature = float(np.clip(2.0 * np.quantile(np.concatenate(bends), 0.95), 2.0, 300.0))
    return Site(
        low_m=tuple(float(x) for x in points.min(0)),
        high_m=tuple(float(x) for x in points.max(0)),
        curvature_1_m=curvature,
        grip_load_n=float(weight / max(grips, 1)),
        table=bundle.environment.table is not None,
    )


def possible(site: Site, unknowns_terms: tuple[Term, ...]) -> list[type[Effect]]:
    """Effects that these recordings could show and that the model has not yet."""
    present = {term.effect.name for term in unknowns_terms}
    present |= {term.effect.widens for term in unknowns_terms}
    absent = [e for e in EFFECTS.values() if e.name not in present and e.widens not in present - {None}]
    return [e for e in absent if site.table or not e.on_table]


def screen(engine: Engine, fit: Fit, site: Site, names: tuple[str, ...]) -> list[Candidate]:
    """Candidates, best first: one per effect, at its best variant.

    Where the engine does not project, each is asked for with the model's own coefficients held, as if they could imitate nothing of it.
    """
    unknowns = fit.unknowns
    tries = [(effect, variant) for effect in possible(site, unknowns.terms) for variant in effect.variants(site)]
    base = unknowns.world(fit.z)
    worlds, steps, owner = [base], [], []
    for number, (effect, variant) in enumerate(tries):
        term = Term.of(effect, variant)
        for k, c in enumerate(term.coefficients):
            if c.shape:
                continue
            values = {other.name: other.centre for other in term.coefficients}
            step = c.twin_z if c.centre + 0.5 * c.scale * c.twin_z <= c.high else -c.twin_z
            values[c.name] = c.value(step)
            worlds.append(effect.alter(base, values))
            steps.append(step)
            owner.append((number, k))
    slopes, extra = _fingerprints(engine, fit, worlds, np.array(steps), names)
    residuals, w = fit.residuals, {name: weights(fit.residuals[name]) / fit.temper[name] for name in names}
    count = len(fit.z)
    normal0 = np.eye(count) + sum((slopes[n].T * w[n]) @ slopes[n] for n in names)
    gradient0 = fit.z + sum(slopes[n].T @ (w[n] * residuals[n]) for n in names)
    low0, high0 = unknowns.bounds()
    alone = bounded_step(normal0, gradient0, fit.z, low0, high0)
    imitated = _fall(normal0, gradient0, alone)
    best: dict[str, Candidate] = {}
    told: dict[str, list[np.ndarray]] = {}
    for number, (effect, variant) in enumerate(tries):
        columns = [index for index, (n, _) in enumerate(owner) if n == number]
        which = [k for n, k in owner if n == number]
        term = Term.of(effect, variant)
        g = {name: extra[name][:, columns] for name in names}
        cross = sum((slopes[n].T * w[n]) @ g[n] for n in names)
        if not engine.projects:
            cross = np.zeros_like(cross)
        own = sum((g[n].T * w[n]) @ g[n] for n in names)
        normal = np.block([[normal0, cross], [cross.T, own + np.eye(len(columns))]])
        gradient = np.concatenate([gradient0, sum(g[n].T @ (w[n] * residuals[n]) for n in names)])
        told.setdefault(effect.name, []).append(np.diag(own - cross.T @ np.linalg.solve(normal0, cross)))
        low, high = unknowns.with_terms(*unknowns.terms, term).bounds()
        picked = [*range(count), *(count + k for k in which)]
        start = np.concatenate([fit.z, np.zeros(len(columns))])
        step = bounded_step(normal, gradient, start, low[picked], high[picked])
        gain = _fall(normal, gradient, step) - imitated
        widened = unknowns.with_terms(*unknowns.terms, term)
        change = np.zeros(widened.count)
        change[picked] = step
        change[:count] -= alone  # what the baseline gains by itself is another search's affair
        # In one line: what the baseline imitated, it gives up as the effect comes in.
        change *= shortened(widened, 2.0 * change)
        found = Candidate(
            term=term,
            gain=float(gain - np.log(len(effect.variants(site)))),
            start=np.concatenate([fit.z, np.zeros(widened.count - count)]) + change,
            variants=len(effect.variants(site)),
        )
        if effect.name not in best or best[effect.name].gain < found.gain:
            best[effect.name] = found
    found = [replace(one, information=typical_information(np.array(told[name]))) for name, one in best.items()]
    return sorted(found, key=lambda candidate: -candidate.gain)


def typical_information(told: np.ndarray) -> tuple[float, ...]:
    """Information (S,), median of the variants (V, S) that show at all: a threshold that no recording crosses tells of no strength."""
    shown = told[told.max(axis=1) > 0.0]
    return tuple(np.median(shown if len(shown) else told, axis=0))


def _fingerprints(
    engine: Engine, fit: Fit, worlds: list[World], steps: np.ndarray, names: tuple[str, ...]
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """How residuals answer to the coefficients of the model (K, P) and to each further world (K, W - 1), both on one mesh.

    A shortlist needs directions, and these the coarser mesh tells in a fifth of the time; where there is none, or the sheet finds no way
    on it, the working one does.
    """
    if engine.other_mesh < engine.finer:
        try:
            with engine.roughly():
                return engine.slopes(fit.unknowns, fit.z, names)[1], engine.answers(worlds, steps, names)
        except NotConverged:
            pass
    return fit.slopes, engine.answers(worlds, steps, names)


def _fall(normal: np.ndarray, gradient: np.ndarray, step: np.ndarray) -> float:
    return -float(gradient @ step + 0.5 * step @ normal @ step)
