"""Models as a search leaves them, made from what each gains: a baseline and others beside it."""

import numpy as np

from sim1.mismatch.decide import decide
from sim1.mismatch.fit import Fit, loss
from sim1.mismatch.models import Model
from sim1.mismatch.thresholds import THRESHOLDS

FIRST, PER_TERM = 1000.0, THRESHOLDS.per_term


def pool_of(unknowns, gains, misfits=None):
    """Models by terms, with the nats that each gains over the baseline, and mean squares of their residuals."""
    misfits, pool = misfits or {}, []
    for terms, gain in {(): 0.0, **gains}.items():
        residual = np.full(10, np.sqrt(misfits.get(terms, 1.0)))
        wanted = FIRST - gain - PER_TERM * len(terms)
        made = Fit(
            unknowns=unknowns,
            z=np.zeros(0),
            names=("only",),
            residuals={"only": residual},
            slopes={"only": np.zeros((10, 0))},
            mesh_off={"only": np.zeros(10)},
            stretch={"only": np.arange(10)},
            temper={"only": float(loss(residual).sum()) / wanted},
            converged=True,
        )
        pool.append(Model(terms=terms, fit=made, variants=1))
    return pool


def verdict(unknowns, gains, misfits=None, thresholds=THRESHOLDS):
    """What such a pool is called, and by which effects."""
    found = decide(pool_of(unknowns, gains, misfits), thresholds)
    return found.verdict, found.chosen.terms


def fitted(unknowns, **mean_squares):
    """A fit by the mean squares of its recordings' residuals."""
    return Fit(
        unknowns=unknowns,
        z=np.zeros(0),
        names=tuple(mean_squares),
        residuals={name: np.full(400, np.sqrt(value)) for name, value in mean_squares.items()},
        slopes={name: np.zeros((400, 0)) for name in mean_squares},
        mesh_off={name: np.zeros(400) for name in mean_squares},
        stretch={name: np.arange(400) // 40 for name in mean_squares},
        temper=dict.fromkeys(mean_squares, 1.0),
        converged=True,
    )
