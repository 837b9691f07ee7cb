"""Leaders are searched to their end on the coarser mesh before they go on where they are compared.

A way that bends takes many steps: as a thread stiffens with its strain, the baseline's stretch, which imitated that, has to go down while it
comes in, and every step promises a few dozen nats of the hundreds at its end. Who is given four steps is then judged by them. On the coarser
mesh a step costs a fourth, so all are given as many as they take; where they arrive there, less what that mesh moves the baseline by, is where
the search on the working mesh goes on, if it costs less there than at the first look. What is gained there also says who need not go on.
"""

from dataclasses import dataclass

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.afresh import afresh
from sim1.mismatch.engine import Engine, Looked
from sim1.mismatch.fit import Fit, cost_of, fit
from sim1.mismatch.screen import Candidate

STEPS = 12  # on the coarser mesh
SETTLED = 3  # of the baseline there


@dataclass(frozen=True, kw_only=True)
class Scouted:
    """Where a search on the coarser mesh arrived."""

    z: np.ndarray  # (P,) on the working mesh
    gain: float  # nats that it gained there


def scouted(engine: Engine, base: Fit, looks: list[Fit], candidates: list[Candidate]) -> list[Scouted | None]:
    """Where searches arrive that begin at these looks, each of which added a candidate to `base`.

    None where no simulation on the coarser mesh finds its way, there is no such mesh, or time is over.
    """
    if engine.other_mesh > engine.finer or engine.patience.over:
        return [None] * len(looks)
    with engine.roughly():
        try:
            rough = fit(engine, base.unknowns, base.z, base.names, temper=base.temper, most=SETTLED, settle=False)
        except NotConverged:
            return [None] * len(looks)
        return [_arrived(engine, base, rough, *one) for one in zip(looks, candidates, strict=True)]


def _arrived(engine: Engine, base: Fit, rough: Fit, look: Fit, candidate: Candidate) -> Scouted | None:
    known = len(base.z)
    start = look.z.copy()
    start[:known] += rough.z - base.z
    try:
        found = fit(engine, look.unknowns, start, base.names, temper=base.temper, most=STEPS, settle=False)
    except NotConverged:
        return None
    found = afresh(engine, rough, found, candidate)
    z = found.z.copy()
    z[:known] -= rough.z - base.z
    return Scouted(z=z, gain=rough.cost - found.cost)


def further(engine: Engine, look: Fit, start: Scouted | None, most: int) -> Fit:
    """A search of `most` steps from `start`, or from the look where that costs less or nothing can be simulated at `start`."""
    looked = None if start is None or engine.patience.over else _better(engine, look, start.z)
    z, given = looked or (look.z, (look.residuals, look.slopes))
    return fit(
        engine,
        look.unknowns,
        z,
        look.names,
        temper=look.temper,
        most=most,
        given=given,
        exact=looked is not None,
    )


def _better(engine: Engine, look: Fit, start: np.ndarray) -> tuple[np.ndarray, Looked] | None:
    z = np.clip(start, *look.unknowns.bounds())
    try:
        looked = engine.slopes(look.unknowns, z, look.names)
    except NotConverged:
        return None
    cost = cost_of(looked[0], look.names, look.temper) + 0.5 * float(z @ z)
    return (z, looked) if cost < look.cost else None
