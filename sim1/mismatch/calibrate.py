"""Fit the parameters of a sheet to recordings: robust least squares with priors, corrected for the coarse mesh.

The search runs on the bundle's own mesh with a long step. What that mesh gets wrong is measured by a run on a mesh of a quarter of the face
size with half the step, extrapolated (second order), added to every prediction, and measured anew in each pass: the fit ends at the
extrapolated optimum at a tenth of the cost of searching there. Kinematics alone determine ratios to the area density; its own value stays near the prior.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from sim1.mismatch.problem import Problem, Twin, rms
from sim1.mismatch.replay import prepare
from sim1.mismatch.sheet import Material
from sim1.mismatch.unknowns import Unknown, with_unknowns
from sim1.recording.bundle import Bundle, Recording

STRETCH_BIAS = 0.3  # log; on stand-in bundles with a finer mesh than ours the stretch came out 0 to 40 % low, whatever the residual said
WIDE_STEP = 0.5  # of the derivatives behind the intervals: a buckle that snaps must not pass for sensitivity


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


class Calibrator:
    """Fits materials to the same recordings again and again."""

    def __init__(self, bundle: Bundle, recordings: tuple[Recording, ...], core_noise_m: float, plan: Plan):
        self._plan, self._noise = plan, core_noise_m
        fine_step = plan.step_s / 2
        self._twins = [
            Twin(recording=r, coarse=prepare(bundle, r, plan.step_s), fine=prepare(bundle, r, fine_step, finer=True))
            for r in recordings
        ]

    def predict(self, material: Material, recording: Recording, bundle: Bundle) -> tuple[np.ndarray, float]:
        """Markers of another recording on the finer mesh, and their discretisation error per coordinate, m."""
        step = self._plan.step_s
        twin = Twin(
            recording=recording,
            coarse=prepare(bundle, recording, step),
            fine=prepare(bundle, recording, step / 2, finer=True),
        )
        return twin.refine(material), rms(twin.error)

    def fit(
        self,
        start: Material,
        names: tuple[Unknown, ...],
        z: np.ndarray,
        progress: Callable[[float], None] = lambda share: None,
        passes: int | None = None,
    ) -> Calibration:
        """Search from `z`; `progress` is told the share done."""
        passes = passes or self._plan.passes
        for twin in self._twins:
            twin.count = twin.fine_count = 0
        inflation, result, sigma = 1.0, None, self._noise
        for number in range(passes):
            material = with_unknowns(start, names, z)
            for twin in self._twins:
                twin.refine(material)
            sigma = [float(np.hypot(self._noise, rms(twin.error))) for twin in self._twins]
            problem = Problem(twins=self._twins, start=start, names=names, sigma=sigma, inflation=inflation)
            done = number / passes
            problem.listener = lambda share, done=done: progress(done + share / passes)
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
        forward, backward = (problem.slopes(z, sign * WIDE_STEP * np.ones(len(z))) for sign in (1, -1))
        data = _agreed(forward, backward)
        scatter = np.linalg.inv(data.T @ data * (problem.inflation / inflation) + np.eye(len(names)))
        biased = [STRETCH_BIAS / unknown.spread if unknown.name == "stretch_n_m" else 0.0 for unknown in names]
        shift = scatter @ data.T @ problem.error() * (problem.inflation / inflation)
        material = with_unknowns(start, names, z)
        markers = {twin.recording.name: twin.refine(material) for twin in self._twins}  # last: it changes the defect
        return Calibration(
            material=material,
            unknowns=names,
            z=z,
            covariance=_at_most_prior(scatter + np.outer(shift, shift) + np.diag(np.square(biased))),
            evaluations=sum(twin.count for twin in self._twins),
            fine_evaluations=sum(twin.fine_count for twin in self._twins),
            converged=bool(result.status > 0),
            inflation=inflation,
            markers_m=markers,
            discretisation_m={twin.recording.name: rms(twin.error) for twin in self._twins},
        )


def _at_most_prior(covariance: np.ndarray) -> np.ndarray:
    """No parameter is less certain than before: the shift is a linear estimate and may overshoot where the data say little."""
    scale = np.minimum(1.0, np.diag(covariance) ** -0.5)
    return covariance * np.outer(scale, scale)


def _agreed(forward: np.ndarray, backward: np.ndarray) -> np.ndarray:
    """Slopes on which both sides agree: the smaller one, and none where their signs differ (a buckle that snaps either way)."""
    return np.where(forward * backward > 0, np.sign(forward) * np.minimum(np.abs(forward), np.abs(backward)), 0.0)
