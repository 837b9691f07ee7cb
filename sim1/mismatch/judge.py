"""How well a fitted model foretells recordings that its fit has not seen, without fitting it again and again.

A fit without one recording lies one Gauss-Newton step from the fit with all: the slopes are known, so every recording can be left out
for the price of a small linear system.
"""

import numpy as np

from sim1.mismatch.fit import Fit, Tempers, bounded_step, loss, weights

LONGEST_Z = (
    3.0  # a step beyond this is no longer small; what the recording says about the coefficient is then everything
)


def foretold(fit: Fit, temper: Tempers) -> np.ndarray:
    """Negative log likelihood [nats] of each fitted recording under the fit without it, in the order of the fit's names."""
    low, high = fit.unknowns.bounds()
    parts = []
    for name in fit.names:
        r, j = fit.residuals[name], fit.slopes[name]
        w = weights(r)
        share = 1.0 / temper[name]
        parts.append((r, j, (j.T * w) @ j * share, j.T @ (w * r) * share, share))
    normal = np.eye(len(fit.z)) + sum(part[2] for part in parts)
    gradient = fit.z + sum(part[3] for part in parts)
    scores = []
    for r, j, own, pull, share in parts:
        step = bounded_step(normal - own, gradient - pull, fit.z, low, high)
        step *= min(1.0, LONGEST_Z / max(np.abs(step).max(), 1e-12))
        scores.append(float(loss(r + j @ step).sum()) * share)
    return np.array(scores)
