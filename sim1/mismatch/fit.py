"""Fit a model to recordings: Gauss-Newton with priors and Student-t weights, slopes from twins."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sim1.cloth.precise.simulate import NotConverged
from sim1.mismatch.compare import Observed
from sim1.mismatch.engine import Engine, Looked
from sim1.mismatch.search import Unknowns

FREEDOM = 5.0  # of the Student-t likelihood
LEAST_CURVATURE = (
    0.6  # of a residual's weight: what bends down is no measure of how far to go, and far off the weights are right
)
CONVERGED = 4e-4  # relative change of the cost that ends a search
LEAST = 0.3  # nats that a step must promise besides
PROMISING = (
    45.0  # nats gained from which more effort is spent; no share of a threshold: these are measured by searches like it
)
MOST_CORRELATED_S = 1.0
LEAST_TEMPER = 3.0  # markers beside each other share what the mesh gets wrong, however white each one's residual is

Tempers = dict[str, float]  # by recording: samples per independent sample
Start = tuple[Unknowns, np.ndarray]  # a model, and z (P,) to search from


def loss(residual: np.ndarray) -> np.ndarray:
    """Negative log likelihood of Student-t residuals, up to a constant; r^2/2 for small ones."""
    return 0.5 * (FREEDOM + 1) * np.log1p(residual**2 / FREEDOM)


def weights(residual: np.ndarray) -> np.ndarray:
    """Weights of the equivalent least squares."""
    return (FREEDOM + 1) / (FREEDOM + residual**2)


def curvatures(residual: np.ndarray) -> np.ndarray:
    """Second derivatives of the loss, at least `LEAST_CURVATURE` of the weights.

    Residuals that are a little large bend it less than their weights say, and steps by these alone stay short (Triggs et al. 2000, section 4.3).
    """
    own = (FREEDOM + 1) * (FREEDOM - residual**2) / (FREEDOM + residual**2) ** 2
    return np.maximum(own, LEAST_CURVATURE * weights(residual))


def secant_weights(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Weights w of the least squares that change by as much from one residual to another: loss(a) - loss(b) = w (a^2 - b^2) / 2."""
    ratio = (before**2 - after**2) / (FREEDOM + after**2)
    flat = np.abs(ratio) < 1e-6
    steep = np.where(flat, 1.0, ratio)
    return weights(after) * np.where(flat, 1.0 - 0.5 * ratio, np.log1p(steep) / steep)


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A model fitted to some recordings."""

    unknowns: Unknowns
    z: np.ndarray  # (P,)
    names: tuple[str, ...]  # fitted
    temper: Tempers
    residuals: dict[str, np.ndarray]  # (K,)
    slopes: dict[str, np.ndarray]  # (K, P)
    mesh_off: dict[str, np.ndarray]  # (K,) what the mesh is taken to be off by
    stretch: dict[str, np.ndarray]  # (K,) which stretch of the recording a residual belongs to
    converged: bool

    @property
    def nominal_z(self) -> np.ndarray:
        """Z of the baseline's coefficients alone."""
        return self.z[: len(self.unknowns.nominal)]

    @property
    def cost(self) -> float:
        """Negative log posterior, up to a constant."""
        return cost_of(self.residuals, self.names, self.temper) + 0.5 * float(self.z @ self.z)

    @property
    def covariance(self) -> np.ndarray:
        """Laplace approximation (P, P)."""
        total = np.eye(len(self.z))
        for name in self.names:
            j = self.slopes[name]
            total = total + (j.T * weights(self.residuals[name])) @ j / self.temper[name]
        return np.linalg.inv(total)


def cost_of(residuals: dict[str, np.ndarray], names: tuple[str, ...], temper: Tempers) -> float:
    """Negative log likelihood of some recordings."""
    return sum(float(loss(residuals[name]).sum()) / temper[name] for name in names)


def cost_at(engine: Engine, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...], temper: Tempers) -> float:
    """Negative log posterior at `z` (P,), without slopes.

    Raises:
        NotConverged: a recording that no simulation follows there.
    """
    return cost_of(engine.residuals(unknowns, z, names), names, temper) + 0.5 * float(z @ z)


def cheapest(
    engine: Engine, starts: list[Start], least: float, names: tuple[str, ...], temper: Tempers
) -> Start | None:
    """The start that costs least, if any costs less than `least`; one that no simulation follows is none."""
    best = None
    for start in starts:
        if engine.patience.over:
            break
        try:
            cost = cost_at(engine, *start, names, temper)
        except NotConverged:
            continue
        if cost < least:
            least, best = cost, start
    return best


def fit(
    engine: Engine,
    unknowns: Unknowns,
    z: np.ndarray,
    names: tuple[str, ...],
    *,
    temper: Tempers,
    most: int = 8,
    enough: float = CONVERGED,
    given: Looked | None = None,
    exact: bool = True,
    settle: bool = True,
    progress: Callable[[float], None] = lambda share: None,
) -> Fit:
    """Search from `z` with the engine's present correction for its step; `most` = 0 only looks at `z`.

    A step is tried with its slopes, which cost about as much as what they come with: the next one knows its way. `given` is what
    `Engine.slopes` says at `z`, or nearly so if it is not `exact`: then slopes are measured before the search is called converged, that
    is, promises less than `enough` of the cost. Without `settle` slopes of the end may be what was given: somebody else goes on from there.
    """
    low, high = unknowns.bounds()
    z = np.clip(z, low, high)
    residuals, slopes = given or engine.slopes(unknowns, z, names)
    exact, converged, taken = exact or given is None, False, 0
    while taken < most and not engine.patience.over:
        normal, gradient = normal_equations(residuals, slopes, z, names, temper)
        cost = cost_of(residuals, names, temper) + 0.5 * float(z @ z)
        step = bounded_step(normal, gradient, z, low, high)
        step *= shortened(unknowns, step)
        hoped = -float(gradient @ step + 0.5 * step @ normal @ step)
        arrived = hoped < LEAST + enough * cost
        followed, better = (True, None) if arrived else _downhill(engine, unknowns, z, step, names, temper, cost)
        if better:
            taken += 1
            progress(taken / most)
            z, (residuals, new) = better
            slopes, exact = (slopes, False) if new is None else (new, True)
        elif exact or (arrived and not settle):
            converged = followed  # also where no way leads down along the slopes: as good as this mesh tells
            break
        else:
            measured = _measured(engine, unknowns, z, names)
            if measured is None:
                break
            (residuals, slopes), exact = measured, True
    return Fit(
        unknowns=unknowns,
        z=z,
        names=names,
        temper=temper,
        residuals=residuals,
        slopes=slopes,
        mesh_off=engine.mesh_off(names),
        stretch=engine.stretches(names),
        converged=converged,
    )


def _measured(engine: Engine, unknowns: Unknowns, z: np.ndarray, names: tuple[str, ...]) -> Looked | None:
    """What `Engine.slopes` says; None where the sheet finds its way and its twins do not, and slopes stay what steps have shown."""
    try:
        return engine.slopes(unknowns, z, names)
    except NotConverged:
        return None


def _downhill(
    engine: Engine,
    unknowns: Unknowns,
    z: np.ndarray,
    step: np.ndarray,
    names: tuple[str, ...],
    temper: Tempers,
    cost: float,
) -> tuple[bool, tuple[np.ndarray, tuple[dict[str, np.ndarray], dict[str, np.ndarray] | None]] | None]:
    """Whether any simulation along `step` found its way; z, residuals and slopes where the cost is lower.

    Slopes are None where the sheet finds its way and its twins do not.
    """
    low, high = unknowns.bounds()
    followed = False
    for share in (1.0, 0.4, 0.1):
        trial = np.clip(z + share * step, low, high)
        new = _measured(engine, unknowns, trial, names)
        try:
            residuals, slopes = new or (engine.residuals(unknowns, trial, names), None)
        except NotConverged:
            continue
        followed = True
        if cost_of(residuals, names, temper) + 0.5 * float(trial @ trial) < cost:
            return True, (trial, (residuals, slopes))
    return followed, None


def normal_equations(
    residuals: dict[str, np.ndarray],
    slopes: dict[str, np.ndarray],
    z: np.ndarray,
    names: tuple[str, ...],
    temper: Tempers,
) -> tuple[np.ndarray, np.ndarray]:
    """Curvature (P, P), second derivatives of the simulation left out, and gradient (P,) of the negative log posterior."""
    normal, gradient = np.eye(len(z)), z.copy()
    for name in names:
        j = slopes[name]
        normal = normal + (j.T * curvatures(residuals[name])) @ j / temper[name]
        gradient = gradient + j.T @ (weights(residuals[name]) * residuals[name]) / temper[name]
    return normal, gradient


def shortened(unknowns: Unknowns, step: np.ndarray) -> float:
    """Share of a step (P,) that changes no coefficient by more than it may."""
    farthest = np.array([c.farthest_z for c in unknowns.all])
    return min(1.0, 1.0 / max(float(np.abs(step / farthest).max()), 1e-12))


def promised(found: Fit) -> float:
    """What one more step would gain if the slopes held, nats."""
    low, high = found.unknowns.bounds()
    normal, gradient = normal_equations(found.residuals, found.slopes, found.z, found.names, found.temper)
    step = bounded_step(normal, gradient, found.z, low, high)
    return -float(gradient @ step + 0.5 * step @ normal @ step)


def bounded_step(normal, gradient, z, low, high) -> np.ndarray:
    """Newton step with coefficients that would leave their limits held there."""
    free = np.ones(len(z), bool)
    step = np.zeros(len(z))
    for _ in range(len(z)):
        step[:] = 0.0
        step[free] = -np.linalg.solve(normal[np.ix_(free, free)], gradient[free])
        leaves = free & (((z + step < low) & (z <= low + 1e-9)) | ((z + step > high) & (z >= high - 1e-9)))
        if not leaves.any():
            break
        free &= ~leaves
    return np.clip(z + step, low, high) - z


def temper_of(engine: Engine, residuals: dict[str, np.ndarray], names: tuple[str, ...]) -> Tempers:
    """Samples per independent sample: `LEAST_TEMPER`, or more where whitening leaves neighbours in time alike.

    Markers that creep over the cloth do it together: as many as err alike count as one.
    """
    found = {}
    for name in names:
        one, residual = engine.observed(name), residuals[name]
        together = _together(one, residual) if one.creep_m else 1.0
        found[name] = max(LEAST_TEMPER, _correlated(one, residual) * together)
    return found


def _together(one: Observed, residual: np.ndarray) -> float:
    """Markers per independent marker, 1 or more: the variance of their sum over the sum of their variances."""
    values = np.zeros(one.kept.shape)
    values[one.kept] = np.clip(residual, -4, 4)
    return max(1.0, float((values.sum(1) ** 2).sum() / (values**2).sum()))


def _correlated(one: Observed, residual: np.ndarray) -> float:
    values = np.zeros(one.kept.shape)
    values[one.kept] = np.clip(residual, -4, 4)
    seen = one.kept.astype(float)
    power = (values**2).sum() / seen.sum()
    step = float(np.median(np.diff(one.block_s)))
    total = 1.0
    for lag in range(1, int(MOST_CORRELATED_S / step)):
        pairs = (seen[lag:] * seen[:-lag]).sum()
        correlation = (values[lag:] * values[:-lag]).sum() / max(pairs, 1.0) / power
        if correlation < 0.05:
            break
        total += 2 * correlation
    return total
