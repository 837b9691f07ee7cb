"""Recordings beside simulations: blocks of frames, their noise, and residuals in units of it.

What a simulator gets wrong is no noise: it lasts, and neighbours share it. Measured less simulated is taken to be white noise and a
discrepancy (Kennedy and O'Hagan 2001) that forgets itself over `LASTING_S` and over `SHARED` of the sheet's size, else a hundred samples of
one lasting error, seen by twenty markers, would count as two thousand witnesses.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial.distance import cdist

from sim1.recording.bundle import Recording
from sim1.recording.motion import rest_until_s

BLOCK_S = (
    0.04  # frames are averaged over this time: 25 Hz resolves what a sheet does, and the fit works on fewer numbers
)
MESH_SHARE = 0.6  # of what refining the mesh changed: taken as the standard deviation of what it still gets wrong
MESH_WINDOW_S = 0.3  # over which that is averaged
MESH_FLOOR_M = 5e-5
LASTING_S = 1.0  # how long the discrepancy remembers: a bend that hangs wrong does so for as long as it hangs
SHARED = 0.5  # of the markers' spread: over which it is alike


@dataclass(frozen=True)
class _Block:
    """What whitening a block of n numbers per axis takes: see `Observed.white`."""

    rows: np.ndarray  # (3, n) which numbers
    markers: np.ndarray  # (n,) whose
    kept: float  # share of the discrepancy that has lasted since the block before
    deviation_m: np.ndarray  # (3, n, 1) of the discrepancy
    whiten: np.ndarray  # (3, n, n) inverse Cholesky factor of the innovation's covariance
    gain: np.ndarray  # (3, M, n) from innovation to discrepancy


@dataclass(frozen=True, kw_only=True)
class Observed:
    """One recording in blocks: K numbers, each the mean of a marker's coordinate over the frames of a block in which it was seen."""

    place_m: np.ndarray  # (M, 2) of the markers, material coordinates
    measured_m: np.ndarray  # (K,)
    kept: np.ndarray  # (B, M, 3) which blocks hold a number
    starts: np.ndarray  # (B,) first frame of each block
    weight: np.ndarray  # (N, M) 1 / frames seen in the block, 0 where not seen
    block_s: np.ndarray  # (B,) mean time of each block
    noise_m: float  # standard deviation of the blocks' means at rest
    mesh_m: np.ndarray  # (K,) what the simulator's mesh is taken to get wrong

    def reduce(self, markers_m: np.ndarray) -> np.ndarray:
        """Markers (..., N, M, 3) as blocks (..., K)."""
        total = np.add.reduceat(markers_m * self.weight[..., None], self.starts, axis=-3)
        return total[..., self.kept]

    @cached_property
    def _blocks(self) -> list[_Block]:
        number = np.cumsum(self.kept.ravel()).reshape(self.kept.shape) - 1
        spread_m = max(float(np.linalg.norm(np.ptp(self.place_m, axis=0))), 1e-9)
        alike = np.exp(-cdist(self.place_m, self.place_m) / (SHARED * spread_m))
        covariance, before, found = np.broadcast_to(alike, (3, *alike.shape)), self.block_s[0], []
        for b, now in enumerate(self.block_s):
            lasting = float(np.exp((before - now) / LASTING_S))
            covariance, before = lasting**2 * covariance + (1 - lasting**2) * alike, now
            markers = np.flatnonzero(self.kept[b, :, 0])
            rows = number[b, markers].T
            deviation = self.mesh_m[rows][..., None]
            shared = covariance[:, :, markers] * np.swapaxes(deviation, 1, 2)  # of discrepancies with numbers
            inner = deviation * shared[:, markers] + self.noise_m**2 * np.eye(len(markers))
            whiten = np.linalg.inv(np.linalg.cholesky(inner))
            gain = shared @ np.swapaxes(whiten, 1, 2) @ whiten
            covariance = covariance - gain @ np.swapaxes(shared, 1, 2)
            found.append(_Block(rows, markers, lasting, deviation, whiten, gain))
        return found

    def white(self, values_m: np.ndarray) -> np.ndarray:
        """Numbers (K, ...) in units of their standard deviation, what lasts and is shared taken out: independent if nothing is missing.

        Innovations of a Kalman filter whose state is the discrepancy at every marker.
        """
        values = values_m.reshape(len(values_m), -1)
        out, discrepancy = np.empty_like(values), np.zeros((3, self.kept.shape[1], values.shape[1]))
        for block in self._blocks:
            discrepancy *= block.kept
            innovation = values[block.rows] - block.deviation_m * discrepancy[:, block.markers]
            out[block.rows] = block.whiten @ innovation
            discrepancy += block.gain @ innovation
        return out.reshape(values_m.shape)


def observe(recording: Recording, place_m: np.ndarray) -> Observed:
    """Cut a recording into blocks; `place_m` (M, 2) is where its markers sit on the sheet."""
    rate = 1.0 / float(np.median(np.diff(recording.time_s)))
    stride = max(1, round(rate * BLOCK_S))
    starts = np.arange(0, len(recording.time_s), stride)
    seen = recording.seen
    count = np.add.reduceat(seen.astype(float), starts, axis=0)
    frames = np.diff(np.append(starts, len(seen)))
    weight = np.where(seen, np.repeat(1.0 / np.maximum(count, 1.0), frames, axis=0), 0.0)
    kept = np.repeat((count > 0.5 * stride)[..., None], 3, axis=2)
    total = np.add.reduceat(np.where(seen[..., None], recording.markers_m, 0.0) * weight[..., None], starts, axis=0)
    return Observed(
        place_m=place_m,
        measured_m=total[kept],
        kept=kept,
        starts=starts,
        weight=weight,
        block_s=np.add.reduceat(recording.time_s, starts) / frames,
        noise_m=0.0,
        mesh_m=np.zeros(int(kept.sum())),
    )


def block_noise_m(observed: list[Observed], recordings: list[Recording]) -> float | None:
    """Scatter of block means while nothing moves, robustly; None where nothing rests long enough."""
    spread, freedom = [], 0
    for one, recording in zip(observed, recordings, strict=True):
        if recording.starts != "rest":
            continue
        values = np.full(one.kept.shape, np.nan)
        values[one.kept] = one.measured_m
        resting = values[one.block_s < rest_until_s(recording) - 0.02]
        count = np.isfinite(resting).sum(0)
        usable = count >= 4
        if usable.any():
            off = resting[:, usable] - np.nanmean(resting[:, usable], axis=0)
            spread.append(off[np.isfinite(off)])
            freedom += int((count[usable] - 1).sum())
    if not spread:
        return None
    off = np.concatenate(spread)
    plain = float(np.sqrt(np.square(off).sum() / freedom))
    core = 1.4826 * float(np.median(np.abs(off))) * np.sqrt(len(off) / freedom)
    return max(core, 0.5 * plain)


def mesh_error(one: Observed, change_m: np.ndarray) -> np.ndarray:
    """Standard deviation (K,) of what the mesh gets wrong, from what refining it changed at the frames (N, M, 3)."""
    blocks = np.zeros(one.kept.shape)
    blocks[one.kept] = one.reduce(change_m) ** 2
    power = blocks.mean(-1)  # (B, M)
    step = float(np.median(np.diff(one.block_s)))
    half = max(1, round(0.5 * MESH_WINDOW_S / step))
    padded = np.pad(power, ((half, half), (0, 0)), mode="edge")
    window = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0).mean(-1)
    spread = 0.5 * window + 0.5 * window.mean(1, keepdims=True)  # a marker that happens to agree is no better known
    error = np.repeat(np.sqrt(spread)[..., None], 3, axis=2)[one.kept]
    return np.hypot(MESH_SHARE * error, MESH_FLOOR_M)
