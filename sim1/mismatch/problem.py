"""What a calibration minimises: recordings beside their simulations on two meshes, residuals, and their slopes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sim1.mismatch.dynamics import NotConverged
from sim1.mismatch.replay import Replay
from sim1.mismatch.sheet import Material
from sim1.mismatch.unknowns import Unknown, with_unknowns
from sim1.recording.bundle import Recording

FD_STEP = 0.1  # in prior standard deviations: far above the solver's tolerance, small against the curvature
HUBER = 2.0  # residuals beyond this many standard deviations count linearly
EXTRAPOLATE = 1 / 3  # error of the finer mesh, in units of what refining changed: second order
LEFT_OVER = (
    1 / 3
)  # what is assumed to be wrong after extrapolation: as much as it adds, for edges of clamps converge more slowly


def rms(x: np.ndarray) -> float:
    """Root mean square of what is not NaN."""
    return float(np.sqrt(np.nanmean(np.square(x))))


def huber(r: np.ndarray) -> np.ndarray:
    """Residuals whose squares are twice Huber's loss."""
    size = np.abs(r)
    return np.where(size <= HUBER, r, np.sign(r) * np.sqrt(np.maximum(2 * HUBER * size - HUBER**2, 0)))


@dataclass
class Twin:
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


@dataclass
class Problem:
    """Residuals and Jacobian of one pass, as scipy wants them: data first, then priors."""

    twins: list[Twin]
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
        robust = huber(data[np.isfinite(data)]) / self.inflation**0.5
        return np.concatenate([robust, z])

    def residuals(self, z: np.ndarray) -> np.ndarray:
        """Data residuals over noise, made robust, then the unknowns themselves (their priors)."""
        if self._last is not None and np.array_equal(self._last[0], z):
            return self._last[1]
        self.calls += 1
        self.listener(min(self.calls / self.planned, 1.0))
        self._last = z.copy(), self._residuals(z)
        return self._last[1]

    def _residuals(self, z: np.ndarray) -> np.ndarray:
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
        step = np.where(z <= 0, FD_STEP, -FD_STEP)  # towards the prior, where materials are sound
        return np.vstack([self.slopes(z, step), np.eye(len(z))])

    def slopes(self, z: np.ndarray, step: np.ndarray) -> np.ndarray:
        """One-sided differences of the data's residuals (N, P) with a step for each unknown."""
        count, names = len(z), [unknown.name for unknown in self.names]
        centre = self.residuals(z)[:-count]
        scaled = [names.index(name) for name in ("stretch_n_m", "bending_n_m", "c_normal") if name in names]
        tied = len(scaled) == (3 if self.start.c_normal or "c_normal" in names else 2)
        slopes = np.zeros((len(centre), count))
        for k, name in enumerate(names):
            if not (tied and name == "area_density_kg_m2"):
                shifted = z.copy()
                shifted[k] += step[k]
                slopes[:, k] = (self._residuals(shifted)[:-count] - centre) / step[k]
        if tied and "area_density_kg_m2" in names:
            k, spread = names.index("area_density_kg_m2"), np.array([unknown.spread for unknown in self.names])
            slopes[:, k] = -spread[k] * (slopes[:, scaled] / spread[scaled]).sum(1)
        return slopes

    def error(self) -> np.ndarray:
        """What the meshes may still get wrong, in units of the residuals (N,)."""
        parts = [(t.error / s)[np.isfinite(t.recording.markers_m)] for t, s in zip(self.twins, self.sigma, strict=True)]
        return np.concatenate(parts) / self.inflation**0.5

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
