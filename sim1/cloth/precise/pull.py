"""Springs from simulated markers to measured ones: a simulation that keeps to a recording.

A sheet forgets what it was told: in a free swing millimetres grow to centimetres, and where a slack sheet can bow to either side the
smallest change decides. Pulled softly, it stays near what was seen, and what it still gets wrong is what its physics gets wrong
(an observer, in the language of control; nudging, in that of weather). The gain is the same for every model.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, make_smoothing_spline
from scipy.spatial.transform import Rotation

from sim1.cloth.precise.world import World

PASS_HZ = 12.0  # smoothing splines let slower motion through; a moving average would cut corners by millimetres
PASS_FRAMES = 0.3  # of the frame rate, where cameras are slow
GAP_S, GAP_FRAMES = 0.03, 0.6  # a marker that is not seen within this time, and as many frames, is left alone
ENDS_S = 0.04  # at the ends of a path its velocity is hardly known
FEWEST = 8  # frames in which a marker must be seen


@dataclass(frozen=True, kw_only=True)
class Goals:
    """Measured paths of M markers, smoothed."""

    first_s: float
    last_s: float
    gap_s: float
    curves: tuple[
        tuple[BSpline, BSpline] | None, ...
    ]  # place and velocity of each marker; None where it was hardly seen
    seen_s: tuple[np.ndarray, ...]  # times at which each was seen

    @classmethod
    def of(cls, time_s: np.ndarray, markers_m: np.ndarray) -> "Goals":
        """From frames (N,) and markers (N, M, 3), NaN where not seen."""
        frame_s = float(np.median(np.diff(time_s)))
        stiffness = 1.0 / (frame_s * (2 * np.pi * min(PASS_HZ, PASS_FRAMES / frame_s)) ** 4)
        curves, times = [], []
        for m in range(markers_m.shape[1]):
            seen = np.isfinite(markers_m[:, m, 0])
            times.append(time_s[seen])
            if seen.sum() < FEWEST:
                curves.append(None)
                continue
            curve = make_smoothing_spline(time_s[seen], markers_m[seen, m], lam=stiffness, axis=0)
            curves.append((curve, curve.derivative()))
        return cls(
            first_s=float(time_s[0]),
            last_s=float(time_s[-1]),
            gap_s=max(GAP_S, GAP_FRAMES * frame_s),
            curves=tuple(curves),
            seen_s=tuple(times),
        )

    def at(self, time_s: np.ndarray, worlds: list[World]) -> tuple[np.ndarray, np.ndarray]:
        """Places and velocities (P, T, M, 3) at the simulation's times (T,) as each world takes the cameras' report; NaN: none."""
        places = np.full((len(worlds), len(time_s), len(self.curves), 3), np.nan)
        speeds = places.copy()
        gone = np.stack([self._gone(m, time_s) for m in range(len(self.curves))], axis=1)
        for p, world in enumerate(worlds):
            if p and _same_cameras(world, worlds[0]):
                places[p], speeds[p] = places[0], speeds[0]
                continue
            at = np.clip(time_s + world.clock_offset_s, self.first_s, self.last_s)
            for m, curve in enumerate(self.curves):
                if curve is not None:
                    places[p, :, m], speeds[p, :, m] = curve[0](at), curve[1](at)
            if any(world.frame_turn_rad) or any(world.frame_shift_m):
                turn = Rotation.from_rotvec(world.frame_turn_rad).as_matrix()
                places[p] = (places[p] - np.array(world.frame_shift_m)) @ turn
                speeds[p] = speeds[p] @ turn
            places[p, gone], speeds[p, gone] = np.nan, np.nan
        return places, speeds

    def _gone(self, m: int, time_s: np.ndarray) -> np.ndarray:
        """Steps (T,) at which a marker cannot pull."""
        outside = (time_s < self.first_s + ENDS_S) | (time_s > self.last_s - ENDS_S)
        if self.curves[m] is None:
            return np.ones(len(time_s), bool)
        times = self.seen_s[m]
        after = np.clip(np.searchsorted(times, time_s), 1, len(times) - 1)
        nearest = np.minimum(np.abs(time_s - times[after - 1]), np.abs(time_s - times[after]))
        return outside | (nearest > self.gap_s)


def _same_cameras(a: World, b: World) -> bool:
    return (a.clock_offset_s, a.frame_shift_m, a.frame_turn_rad) == (
        b.clock_offset_s,
        b.frame_shift_m,
        b.frame_turn_rad,
    )


@dataclass(frozen=True, kw_only=True)
class Pull:
    """Critically damped springs on all markers.

    Each is as stiff as its share of the sheet's mass in the world that is simulated asks for: recordings tell stiffness only in
    units of the mass, and a gain in newtons would let a model fit better by being lighter.
    """

    hz: float  # how fast a free marker follows
    goals: Goals

    @property
    def rate_1_s(self) -> float:
        """Angular frequency."""
        return 2 * np.pi * self.hz
