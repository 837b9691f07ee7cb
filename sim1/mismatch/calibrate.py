"""Fit the parameters of a sheet to recordings: robust least squares with priors, corrected for the coarse mesh.

The search runs on the bundle's own mesh with a long step. What that mesh gets wrong is measured by a run on a mesh of a quarter of the face
size with half the step, extrapolated (second order), added to every prediction, and measured anew in each pass: the fit ends at the
extrapolated optimum at a tenth of the cost of searching there. Kinematics alone determine ratios to the area density; its own value stays near the prior.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from sim1.mismatch.dynamics import NotConverged
from sim1.mismatch.replay import Replay, prepare
from sim1.mismatch.sheet import Material
from sim1.mismatch.unknowns import Unknown, with_unknowns
from sim1.recording.bundle import Bundle, Recording

FD_STEP = 0.1  # in prior standard deviations: far above the solver's tolerance, small against the curvature
HUBER = 2.0  # residuals beyond this many standard deviations count linearly
EXTRAPOLATE = (
    1 / 3
)  # error of the finer mesh in units of the change that refining brought: mesh and steps are second order
LEFT_OVER = 1 / 6  # what is assumed to be wrong after extrapolation: half of what it adds


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How long a calibration may take and how accurate it is."""

    step_s: float
    passes: int
    iterations: int  # of least squares, per pass
    tolerance: float  # relative change of the cost that ends a pass


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Result of a calibration."""

    material: Material
    unknowns: tuple[Unknown, ...]
    z: np.ndarray  # (P,) in prior standard deviations
    covariance: np.ndarray  # (P, P) of z: Laplace, and what the mesh's remaining error may have shifted
    evaluations: int  # coarse simulations of one recording
    fine_evaluations: int
    converged: bool
    inflation: float  # samples per independent sample, times the misfit: what the data's weight was divided by
    markers_m: dict[str, np.ndarray]  # recording -> (T, M, 3) on the finer mesh
    discretisation_m: dict[str, float]  # recording -> estimated error of those, per coordinate

    def interval(self, index: int) -> tuple[float, float]:
        """95 % interval of an unknown."""
        unknown, reach = self.unknowns[index], 1.96 * float(self.covariance[index, index] ** 0.5)
        return unknown.value(self.z[index] - reach), unknown.value(self.z[index] + reach)


def _huber(r: np.ndarray) -> np.ndarray:
    """Residuals whose squares are twice Huber's loss."""
    size = np.abs(r)
    return np.where(size <= HUBER, r, np.sign(r) * np.sqrt(np.maximum(2 * HUBER * size - HUBER**2, 0)))


@dataclass
class _Twin:
    """A recording with its coarse and fine replays, and the last equilibria as starts for the next."""

    recording: Recording
    coarse: Replay
    fine: Replay
    defect: np.ndarray | None = None  # (T, M, 3) added to the coarse prediction
    error: np.ndarray | None = None  # (T, M, 3) estimate of what is wrong after that
    rest: np.ndarray | None = None
    fine_rest: np.ndarray | None = None
    count: int = 0
    fine_count: int = 0

    def predict(self, material: Material) -> np.ndarray:
        shapes = self.coarse.shapes(material, self.rest)
        self.count += 1
        if self.rest is None:
            self.rest = shapes[0].copy()
        return self.coarse.markers(shapes) + (0 if self.defect is None else self.defect)

    def refine(self, material: Material) -> np.ndarray:
        """Markers extrapolated from both meshes; what the coarse one lacks is kept for `predict`."""
        shapes = self.fine.shapes(material, self.fine_rest)
        self.fine_rest, self.rest = shapes[0].copy(), None
        self.fine_count += 1
        fine, self.defect = self.fine.markers(shapes), None
        change = fine - self.predict(material)
        self.error, self.defect = LEFT_OVER * change, (1 + EXTRAPOLATE) * change
        return fine + EXTRAPOLATE * change


class Calibrator:
    """Fits materials to the same recordings again and again."""

    def __init__(self, bundle: Bundle, recordings: tuple[Recording, ...], core_noise_m: float, plan: Plan):
        self._plan, self._noise = plan, core_noise_m
        fine_step = plan.step_s / 2
        self._twins = [
            _Twin(recording=r, coarse=prepare(bundle, r, plan.step_s), fine=prepare(bundle, r, fine_step, finer=True))
            for r in recordings
        ]

    def predict(self, material: Material, recording: Recording, bundle: Bundle) -> tuple[np.ndarray, float]:
        """Markers of another recording on the finer mesh, and their discretisation error per coordinate, m."""
        step = self._plan.step_s
        twin = _Twin(
            recording=recording,
            coarse=prepare(bundle, recording, step),
            fine=prepare(bundle, recording, step / 2, finer=True),
        )
        return twin.refine(material), _rms(twin.error)

    def fit(
        self,
        start: Material,
        names: tuple[Unknown, ...],
        z: np.ndarray,
        progress: Callable[[float, str], None] = lambda share, what: None,
    ) -> Calibration:
        """Search from `z`; `progress` is told the share done and what is done."""
        for twin in self._twins:
            twin.count = twin.fine_count = 0
        inflation, result, sigma = 1.0, None, self._noise
        for number in range(self._plan.passes):
            material = with_unknowns(start, names, z)
            for twin in self._twins:
                twin.refine(material)
            sigma = [float(np.hypot(self._noise, _rms(twin.error))) for twin in self._twins]
            problem = _Problem(twins=self._twins, start=start, names=names, sigma=sigma, inflation=inflation)
            done = number / self._plan.passes
            problem.listener = lambda share, done=done: progress(done + share / self._plan.passes, "fitting")
            problem.planned = self._plan.iterations
            result = least_squares(
                problem.residuals,
                z,
                problem.jacobian,
                method="trf",
                ftol=self._plan.tolerance,
                xtol=1e-3,
                gtol=1e-6,
                max_nfev=self._plan.iterations,
            )
            z = result.x
            inflation = problem.inflation_at(z)
        material = with_unknowns(start, names, z)
        markers = {twin.recording.name: twin.refine(material) for twin in self._twins}
        data = result.jac[: -len(names)]
        shift = problem.shift_of(result.jac)
        scatter = np.linalg.inv(data.T @ data * (problem.inflation / inflation) + np.eye(len(names)))
        return Calibration(
            material=material,
            unknowns=names,
            z=z,
            covariance=scatter + np.outer(shift, shift),
            evaluations=sum(twin.count for twin in self._twins),
            fine_evaluations=sum(twin.fine_count for twin in self._twins),
            converged=bool(result.status > 0),
            inflation=inflation,
            markers_m=markers,
            discretisation_m={twin.recording.name: _rms(twin.error) for twin in self._twins},
        )


def _rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.nanmean(np.square(x))))


@dataclass
class _Problem:
    """Residuals and Jacobian of one pass, as scipy wants them: data first, then priors."""

    twins: list[_Twin]
    start: Material
    names: tuple[Unknown, ...]
    sigma: list[float]
    inflation: float
    listener: Callable[[float], None] = lambda share: None
    planned: int = 1
    calls: int = 0
    _last: tuple[np.ndarray, np.ndarray] | None = None

    def _data(self, z: np.ndarray) -> np.ndarray:
        """Differences over noise, NaN where unseen, all recordings in one (N,)."""
        material = with_unknowns(self.start, self.names, z)
        parts = [(t.predict(material) - t.recording.markers_m) / s for t, s in zip(self.twins, self.sigma, strict=True)]
        return np.concatenate([part.ravel() for part in parts])

    def _whole(self, data: np.ndarray, z: np.ndarray) -> np.ndarray:
        robust = _huber(data[np.isfinite(data)]) / self.inflation**0.5
        return np.concatenate([robust, z])

    def residuals(self, z: np.ndarray) -> np.ndarray:
        """Data residuals over noise, made robust, then the unknowns themselves (their priors)."""
        if self._last is not None and np.array_equal(self._last[0], z):
            return self._last[1]
        found = self._residuals(z)
        self._last = z.copy(), found
        return found

    def _residuals(self, z: np.ndarray) -> np.ndarray:
        self.calls += 1
        self.listener(min(self.calls / self.planned, 1.0))
        try:
            return self._whole(self._data(z), z)
        except NotConverged:  # an impossible material: as bad as it gets, so that the search turns back
            return np.concatenate([np.full(self._count, 1e3), z])

    @property
    def _count(self) -> int:
        return int(sum(np.isfinite(t.recording.markers_m).sum() for t in self.twins))

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """Derivative of `residuals`, one-sided differences; the area density's from the others.

        A held sheet without contact moves the same when density, stiffnesses and drag are all scaled alike. Differences would
        break that, and the search would run away along the direction in which nothing changes.
        """
        centre, names = self.residuals(z), [unknown.name for unknown in self.names]
        scaled = [names.index(name) for name in ("stretch_n_m", "bending_n_m", "c_normal") if name in names]
        known = len(scaled) < (3 if self.start.c_normal or "c_normal" in names else 2)
        jacobian = np.zeros((len(centre), len(z)))
        for k, name in enumerate(names):
            if name == "area_density_kg_m2" and not known:
                continue
            shifted = z.copy()
            shifted[k] += FD_STEP if z[k] <= 0 else -FD_STEP  # towards the prior, where materials are sound
            jacobian[:, k] = (self._whole(self._data(shifted), shifted) - centre) / (shifted[k] - z[k])
        if "area_density_kg_m2" in names and not known:
            k, spread = names.index("area_density_kg_m2"), np.array([unknown.spread for unknown in self.names])
            jacobian[: -len(z), k] = -spread[k] * (jacobian[: -len(z)][:, scaled] / spread[scaled]).sum(1)
        jacobian[-len(z) :] = np.eye(len(z))
        return jacobian

    def shift_of(self, jacobian: np.ndarray) -> np.ndarray:
        """How far the estimated discretisation error moves the unknowns, in prior standard deviations."""
        parts = [(t.error / s)[np.isfinite(t.recording.markers_m)] for t, s in zip(self.twins, self.sigma, strict=True)]
        error = np.concatenate(parts) / self.inflation**0.5
        return np.linalg.solve(jacobian.T @ jacobian, jacobian[: -len(self.names)].T @ error)

    def inflation_at(self, z: np.ndarray) -> float:
        """How many samples make one independent one, times the mean squared misfit: neighbours in time share the model's error."""
        material = with_unknowns(self.start, self.names, z)
        total, square = [], []
        for twin, sigma in zip(self.twins, self.sigma, strict=True):
            r = np.clip((twin.predict(material) - twin.recording.markers_m) / sigma, -2 * HUBER, 2 * HUBER)
            r = r.reshape(len(r), -1)
            seen = np.isfinite(r)
            filled = np.where(seen, r, 0.0)
            power = (filled**2).sum()
            correlation, time = 1.0, 1.0
            for lag in range(1, len(r) // 3):
                pairs = (seen[lag:] & seen[:-lag]).sum()
                correlation = (filled[lag:] * filled[:-lag]).sum() / max(pairs, 1) * seen.sum() / power
                if correlation < 0.05:
                    break
                time += 2 * correlation
            total.append(time)
            square.append(power / seen.sum())
        return max(1.0, float(np.mean(total)) * max(1.0, float(np.mean(square))))
