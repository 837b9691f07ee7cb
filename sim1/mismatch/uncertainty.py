"""How far off fitted coefficients may be: the noise, what recordings disagree on, and what the mesh gets wrong.

Laplace's covariance takes the simulator for right and its errors for independent. Where it is wrong, it is wrong in its own way in every
recording, and in one way in all of them where its mesh is to blame. Three parts, added:

* Laplace's, widened: nearby markers share errors.
* The scatter among recordings: what each pulls the coefficients by, the covariance of a cluster-robust (sandwich) estimator (Liang and Zeger
  1986) with recordings as clusters. These are few: Student's quantile in place of the normal one, with Welch's and Satterthwaite's degrees of
  freedom.
* The mesh: what the coefficients would change by with what it is taken to be off by.
"""

import numpy as np
from scipy import stats

from sim1.mismatch.fit import Fit, secant_weights, weights

WIDEN = 2.0  # of Laplace's standard deviations; see docs/mismatch.md for what the intervals hold
QUANTILE = 0.975
HELD = 2.0  # stretches of time that those seen are weighed against


def covariance(found: Fit, quantile: float = QUANTILE) -> np.ndarray:
    """Covariance (P, P) of z, such that 1.96 of its standard deviations are a 95 % interval, or another `quantile`'s that of the normal one."""
    laplace = WIDEN**2 * found.covariance
    among = scatter(found)
    shift = mesh_shift(found)
    whole = laplace + among + np.outer(shift, shift)
    share = np.diag(among) / np.diag(whole)
    freedom = max(len(found.names) - 1, 1) / np.maximum(share**2, 1e-12)
    longer = stats.t.ppf(quantile, freedom) / stats.norm.ppf(quantile)
    return whole * np.outer(longer, longer)


def deviations(found: Fit) -> np.ndarray:
    """Standard deviations (P,) of z."""
    return np.sqrt(np.diag(covariance(found)))


def established(found: Fit, term: int, level: float) -> bool:
    """Whether the strengths of an effect differ from nothing: Wald's test of all of them, at `level`, with `covariance`.

    Evidence grows with every sample that is fitted better, also where recordings pull a coefficient to and fro, each by its own
    error of the simulator.
    """
    whole = covariance(found, 1.0 - 0.5 * level)
    places = found.unknowns.strengths(term)
    strengths = found.z[places]
    distance = float(strengths @ np.linalg.solve(whole[np.ix_(places, places)], strengths))
    return stats.chi2.sf(distance, len(places)) <= level


def established_along(found: Fit, base: Fit, level: float) -> bool:
    """Whether what a model adds to `base` differs from nothing: the same test, along the way from one to the other.

    For a straight model the two are one. Where cloth sticks and slips, slopes at the end of the way are wild, and say nothing of an
    effect far from nothing (Hauck and Donner 1977): by them a static friction that gained 2939 nats could be nothing. Along the way a
    residual changed by d, a share 1 of it; that share is tested, with the same three parts of its variance.
    """
    pulls, information, off = [], 0.0, 0.0
    for name in found.names:
        taken, weight = base.residuals[name] - found.residuals[name], _way_weights(found, base, name)
        pulls.append(float((weight * taken * found.residuals[name]).sum()))
        information += float((weight * taken**2).sum())
        off += float((weight * taken * found.mesh_off[name]).sum())
    if information <= 0.0:
        return False
    count = len(pulls)
    among = count / (count - 1) * float(np.var(pulls)) * count / information**2 if count > 1 else 0.0
    whole = WIDEN**2 / information + among + (off / information) ** 2
    freedom = max(count - 1, 1) / max((among / whole) ** 2, 1e-12)
    return np.sqrt(whole) * stats.t.ppf(1.0 - 0.5 * level, freedom) <= 1.0


def overcounted(found: Fit, base: Fit) -> float:
    """How often what a model gains over `base` counts the same error of the simulator; 1 where it counts each once.

    A sheet that bends a little wrong takes all markers along, for as long as it does: many residuals, one witness. A model takes some
    part d off every residual; what it leaves, r, has nothing in common with d where it is independent: the sum of d r over a stretch of
    time varies as the sum of d^2. By how much more it does is the factor by which the ratio of likelihoods is too large (Kent 1982, along
    the way from `base` to the model: differences, no slopes, which are wild where cloth sticks and slips).
    """
    return _counted(*_stretches(found, base))


def unsteadiness(found: Fit, base: Fit) -> float:
    """By what share of itself what a model adds to `base` differs from one stretch of time to the next; 0 where it is the same.

    Each stretch would have 1 - a of it, with a of the variance that its information grants and of what comes on top: the moment
    estimate of a random effect (DerSimonian and Laird 1986), with the squared information as weights.
    """
    pulls, information = _stretches(found, base)
    if not information.any():
        return 0.0
    return float(np.sqrt((_counted(pulls, information) - 1.0) * information.sum() / (information**2).sum()))


def _counted(pulls: np.ndarray, information: np.ndarray) -> float:
    """Variance of the pulls over what their information says, 1 or more; few that count tell little, and are held to 1.

    The fit has seen to it that pulls add up to nothing: of n that count, n - 1 are free to vary.
    """
    total = float(information.sum())
    if total <= 0.0:
        return 1.0
    count = total**2 / float((information**2).sum())
    return max(1.0, (count * float((pulls**2).sum()) / total + HELD) / (count - 1.0 + HELD))


def _stretches(found: Fit, base: Fit) -> tuple[np.ndarray, np.ndarray]:
    """By stretch: d r and d^2, summed with the weights by which the likelihood gains exactly their sum, d (r + d / 2)."""
    pulls, information = [], []
    for name in found.names:
        residual = found.residuals[name]
        taken, weight = base.residuals[name] - residual, _way_weights(found, base, name)
        first = np.flatnonzero(np.diff(found.stretch[name], prepend=found.stretch[name][:1] - 1))
        pulls.append(np.add.reduceat(weight * taken * residual, first))
        information.append(np.add.reduceat(weight * taken**2, first))
    return np.concatenate(pulls), np.concatenate(information)


def _way_weights(found: Fit, base: Fit, name: str) -> np.ndarray:
    """Weights (K,) of a recording's residuals along the way from `base`, tempered."""
    return secant_weights(base.residuals[name], found.residuals[name]) / found.temper[name]


def scatter(found: Fit) -> np.ndarray:
    """Covariance (P, P) by which recordings disagree; zero with one recording, which disagrees with none."""
    count = len(found.names)
    if count < 2:
        return np.zeros_like(found.covariance)
    pulls = np.array([pull(found, name, found.residuals[name]) for name in found.names])
    off = (pulls - pulls.mean(0)) @ found.covariance
    return count / (count - 1) * off.T @ off


def mesh_shift(found: Fit) -> np.ndarray:
    """By how much z (P,) would differ with what the mesh is taken to be off by, to first order."""
    return -found.covariance @ sum(pull(found, name, found.mesh_off[name]) for name in found.names)


def pull(found: Fit, name: str, residual: np.ndarray) -> np.ndarray:
    """Gradient (P,) of the negative log likelihood of a recording if its residuals were `residual` (K,), weights as fitted."""
    return found.slopes[name].T @ (weights(found.residuals[name]) * residual) / found.temper[name]
