"""How far off fitted coefficients may be: the noise, what recordings disagree on, and what the mesh gets wrong.

Laplace's covariance takes the simulator for right and its errors for independent. Where it is wrong, it is wrong in its own way in every
recording, and in one way in all of them where its mesh is to blame. Three parts, added:

* Laplace's, widened: nearby markers share errors.
* The scatter among recordings: what each pulls the coefficients by, the covariance of a cluster-robust (sandwich) estimator (Liang and Zeger
  1986) with recordings as clusters. These are few: Student's quantile in place of the normal one, with Welch's and Satterthwaite's degrees of
  freedom.
* The mesh: what the coefficients would be on the coarser one, times the share of that change that the working one is taken to be off by.
"""

from collections.abc import Collection

import numpy as np
from scipy import stats

from sim1.mismatch.compare import MESH_SHARE
from sim1.mismatch.fit import Fit, weights

WIDEN = 2.0  # of Laplace's standard deviations; see docs/mismatch.md for what the intervals hold
QUANTILE = 0.975


def covariance(found: Fit) -> np.ndarray:
    """Covariance (P, P) of z, such that 1.96 of its standard deviations are a 95 % interval."""
    laplace = WIDEN**2 * found.covariance
    among = scatter(found)
    shift = MESH_SHARE * mesh_shift(found)
    whole = laplace + among + np.outer(shift, shift)
    share = np.diag(among) / np.diag(whole)
    freedom = max(len(found.names) - 1, 1) / np.maximum(share**2, 1e-12)
    longer = stats.t.ppf(QUANTILE, freedom) / stats.norm.ppf(QUANTILE)
    return whole * np.outer(longer, longer)


def deviations(found: Fit) -> np.ndarray:
    """Standard deviations (P,) of z."""
    return np.sqrt(np.diag(covariance(found)))


def established(found: Fit, level: float) -> bool:
    """Whether each effect's strengths differ from nothing: Wald's test of all of them, at `level`, with `covariance`.

    Evidence grows with every sample that is fitted better, also where recordings pull a coefficient to and fro, each by its own
    error of the simulator.
    """
    whole = covariance(found)
    for term in range(len(found.unknowns.terms)):
        places = found.unknowns.strengths(term)
        strengths = found.z[places]
        distance = float(strengths @ np.linalg.solve(whole[np.ix_(places, places)], strengths))
        if stats.chi2.sf(distance, len(places)) > level:
            return False
    return True


def overcounted(found: Fit, names: Collection[str] | None = None) -> float:
    """How often evidence for effects (all, or those of `names`) counts the same error of the simulator; 1 where it counts each once.

    A sheet that bends a little wrong takes all markers along, for as long as it does: many residuals, one witness. How far stretches of
    time pull the strengths to and fro (the sandwich again, stretches as clusters), in units of the variance that independent residuals
    would give, in the mean over the strengths: the factor by which a ratio of likelihoods is too large (Kent 1982).
    """
    terms = found.unknowns.terms
    wanted = [k for k, term in enumerate(terms) if names is None or term.effect.name in names]
    places = [place for k in wanted for place in found.unknowns.strengths(k)]
    pulls = [_pulls_by_stretch(found, name) for name in found.names]
    count = sum(map(len, pulls))
    if not places or count < 2:
        return 1.0
    each = np.concatenate(pulls)
    each = ((each - each.mean(0)) @ found.covariance)[:, places]
    prior = found.covariance[places] @ found.covariance[:, places]
    robust = count / (count - 1) * each.T @ each + prior
    plain = found.covariance[np.ix_(places, places)]
    return max(1.0, float(np.trace(np.linalg.solve(plain, robust))) / len(places))


def _pulls_by_stretch(found: Fit, name: str) -> np.ndarray:
    """Gradients (stretches, P) of a recording's negative log likelihood."""
    residual = found.residuals[name]
    each = found.slopes[name] * (weights(residual) * residual)[:, None] / found.temper[name]
    first = np.flatnonzero(np.diff(found.stretch[name], prepend=-1))
    return np.add.reduceat(each, first, axis=0)


def scatter(found: Fit) -> np.ndarray:
    """Covariance (P, P) by which recordings disagree; zero with one recording, which disagrees with none."""
    count = len(found.names)
    if count < 2:
        return np.zeros_like(found.covariance)
    pulls = np.array([pull(found, name, found.residuals[name]) for name in found.names])
    off = (pulls - pulls.mean(0)) @ found.covariance
    return count / (count - 1) * off.T @ off


def mesh_shift(found: Fit) -> np.ndarray:
    """By how much z (P,) would differ on the coarser mesh, to first order."""
    return -found.covariance @ sum(pull(found, name, found.coarser[name]) for name in found.names)


def pull(found: Fit, name: str, residual: np.ndarray) -> np.ndarray:
    """Gradient (P,) of the negative log likelihood of a recording if its residuals were `residual` (K,), weights as fitted."""
    return found.slopes[name].T @ (weights(found.residuals[name]) * residual) / found.temper[name]
