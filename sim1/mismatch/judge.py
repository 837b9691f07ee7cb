"""How well a fitted model foretells motion that its fit has not seen, without fitting it again and again.

A fit without one fold lies one Gauss-Newton step from the fit with all: the slopes are known, so every fold can be left out for the
price of a small linear system. A fold is half of a recording.
"""

import numpy as np

from sim1.mismatch.engine import Engine
from sim1.mismatch.fit import Fit, _bounded_step, loss, weights

LONGEST_Z = 0.7  # a step beyond this is no longer small; what the fold says about the coefficient is then everything


def folds(engine: Engine, names: tuple[str, ...]) -> list[tuple[str, np.ndarray]]:
    """(recording, mask (K,)) of each fold."""
    found = []
    for name in names:
        time = engine.observed(name).time_s
        middle = np.median(time)
        found += [(name, time <= middle), (name, time > middle)]
    return found


def foretold(engine: Engine, fit: Fit, temper: float) -> np.ndarray:
    """Negative log likelihood [nats] of each fold under the fit without it, in the order of `folds`."""
    low, high = fit.unknowns.bounds()
    parts = []
    for name, mask in folds(engine, fit.names):
        r, j = fit.residuals[name][mask], fit.slopes[name][mask]
        w = weights(r)
        parts.append((r, j, (j.T * w) @ j / temper, j.T @ (w * r) / temper))
    normal = np.eye(len(fit.z)) + sum(part[2] for part in parts)
    gradient = fit.z + sum(part[3] for part in parts)
    scores = []
    for r, j, own, pull in parts:
        step = _bounded_step(normal - own, gradient - pull, fit.z, low, high)
        step *= min(1.0, LONGEST_Z / max(np.abs(step).max(), 1e-12))
        scores.append(float(loss(r + j @ step).sum()) / temper)
    return np.array(scores)
