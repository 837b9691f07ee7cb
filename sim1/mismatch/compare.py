"""Recordings beside simulations: blocks of frames, their noise, and residuals in units of it.

What a simulator gets wrong is no noise: it lasts. Measured less simulated is taken to be white noise and a discrepancy that forgets
itself over `LASTING_S` (Kennedy and O'Hagan 2001, with the covariance of an Ornstein-Uhlenbeck process along each marker's coordinate),
else a hundred samples of one lasting error would count as a hundred witnesses. Markers that creep over the cloth are wrong in that way too.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from sim1.recording.bundle import Bundle, Recording
from sim1.recording.motion import UNTOLD_S, rest_until_s
from sim1.stage import BadInput

BLOCK_S = (
    0.04  # frames are averaged over this time: 25 Hz resolves what a sheet does, and the fit works on fewer numbers
)
MESH_SHARE = 0.6  # of what refining the mesh changed: what it still gets wrong, if changes fall off to 0.375 each time
MESH_WINDOW_S = 0.3  # over which that is averaged
MESH_FLOOR_M = 5e-5
LASTING_S = 1.0  # how long the discrepancy remembers: a bend that hangs wrong does so for as long as it hangs


@dataclass(frozen=True, kw_only=True)
class Observed:
    """One recording in blocks: K numbers, each the mean of a marker's coordinate over the frames of a block in which it was seen."""

    measured_m: np.ndarray  # (K,)
    kept: np.ndarray  # (B, M, 3) which blocks hold a number
    starts: np.ndarray  # (B,) first frame of each block
    weight: np.ndarray  # (N, M) 1 / frames seen in the block, 0 where not seen
    block_s: np.ndarray  # (B,) mean time of each block
    noise_m: float  # standard deviation of the blocks' means at rest
    creep_m: float  # of where markers are on the cloth
    mesh_m: np.ndarray  # (K,) what the simulator's mesh is taken to get wrong

    def reduce(self, markers_m: np.ndarray) -> np.ndarray:
        """Markers (..., N, M, 3) as blocks (..., K)."""
        total = np.add.reduceat(markers_m * self.weight[..., None], self.starts, axis=-3)
        return total[..., self.kept]

    @property
    def stretch(self) -> np.ndarray:
        """Which stretch of `LASTING_S` each number (K,) belongs to: what is wrong in one says nothing of the next."""
        number = np.floor(self.block_s / LASTING_S).astype(int)
        return np.broadcast_to(number[:, None, None], self.kept.shape)[self.kept]

    @cached_property
    def _factors(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Per marker and coordinate: which numbers, and the Cholesky factor of their covariance."""
        number = np.cumsum(self.kept.ravel()).reshape(self.kept.shape) - 1
        found = []
        for m in range(self.kept.shape[1]):
            for axis in range(3):
                blocks = np.flatnonzero(self.kept[:, m, axis])
                if len(blocks):
                    rows, time = number[blocks, m, axis], self.block_s[blocks]
                    lasting = np.exp(-np.abs(time[:, None] - time) / LASTING_S)
                    covariance = (self.mesh_m[rows, None] * self.mesh_m[rows] + self.creep_m**2) * lasting
                    covariance[np.diag_indices(len(rows))] += self.noise_m**2
                    found.append((rows, np.linalg.cholesky(covariance)))
        return found

    def white(self, values_m: np.ndarray) -> np.ndarray:
        """Numbers (K, ...) in units of their standard deviation, what lasts taken out: independent if nothing is missing."""
        out = np.empty_like(values_m)
        for rows, factor in self._factors:
            out[rows] = solve_triangular(factor, values_m[rows], lower=True, check_finite=False)
        return out


def observe(recording: Recording) -> Observed:
    """Cut a recording into blocks; noise and creep are filled in by the engine.

    The first `UNTOLD_S` of a recording that starts moving count in no model, as what a delay does there depends on what drives did
    before their first sample, which nobody knows: simulated drives stand there, and every delay would be charged for that.
    """
    rate = 1.0 / float(np.median(np.diff(recording.time_s)))
    stride = max(1, round(rate * BLOCK_S))
    starts = np.arange(0, len(recording.time_s), stride)
    seen = recording.seen
    count = np.add.reduceat(seen.astype(float), starts, axis=0)
    frames = np.diff(np.append(starts, len(seen)))
    weight = np.where(seen, np.repeat(1.0 / np.maximum(count, 1.0), frames, axis=0), 0.0)
    block_s = np.add.reduceat(recording.time_s, starts) / frames
    told = np.ones(len(starts), bool)
    if recording.starts == "moving":
        told = block_s >= recording.time_s[0] + UNTOLD_S
    kept = np.repeat(((count > 0.5 * stride) & told[:, None])[..., None], 3, axis=2)
    total = np.add.reduceat(np.where(seen[..., None], recording.markers_m, 0.0) * weight[..., None], starts, axis=0)
    return Observed(
        measured_m=total[kept],
        kept=kept,
        starts=starts,
        weight=weight,
        block_s=block_s,
        noise_m=0.0,
        creep_m=0.0,
        mesh_m=np.zeros(int(kept.sum())),
    )


def block_frames(one: Observed) -> float:
    """Frames in a block."""
    return float(np.median(np.diff(one.starts)))


def noise_of_blocks_m(bundle: Bundle, observed: list[Observed]) -> list[float]:
    """Standard deviation of blocks' means [m] of each recording, which fits work with: measured at rest, else from what the bundle states of a frame.

    Recordings with as many frames in a block share it. Where none of them rests, it is told from those that have the nearest number of
    frames and do, as if noise were white.

    Raises:
        BadInput: nothing that rests shows it, and the bundle states none.
    """
    frames = [block_frames(one) for one in observed]
    measured = dict[float, float]()
    for count in sorted(set(frames)):
        alike = [(one, r) for one, r, own in zip(observed, bundle.recordings, frames, strict=True) if own == count]
        if found := block_noise_m([one for one, _ in alike], [recording for _, recording in alike]):
            measured[count] = found
    if not measured:
        if bundle.noise_std_m is None:
            raise BadInput(
                f"{bundle.folder / 'bundle.yaml'}: markers.noise_std_m is null and no recording that rests for 0.2 s or more shows "
                "it; state the markers' noise in m, or let the cloth rest before it moves"
            )
        measured[1.0] = bundle.noise_std_m
    nearest = [min(measured, key=lambda count: abs(np.log(count / own))) for own in frames]
    return [measured[near] * float(np.sqrt(near / own)) for near, own in zip(nearest, frames, strict=True)]


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


def off_by_coarser(here_m: np.ndarray, coarser_m: np.ndarray) -> np.ndarray:
    """What a mesh gets wrong [m], by what a coarser one says: all changes to come are `MESH_SHARE` of the last one. Arrays of one shape."""
    return MESH_SHARE * (coarser_m - here_m)


def off_by_finer(here_m: np.ndarray, finer_m: np.ndarray) -> np.ndarray:
    """What a mesh gets wrong, by what a finer one says: the change to it, and `MESH_SHARE` of that still to come [m]. Arrays of one shape.

    Where changes fall off as they should this is what `off_by_coarser` says; around the corner of a clamp, or where wrinkles have a choice,
    they fall off more slowly or not at all, and this is more.
    """
    return (1.0 + MESH_SHARE) * (here_m - finer_m)


def mesh_error(one: Observed, off_m: np.ndarray) -> np.ndarray:
    """Standard deviation (K,) of what the mesh gets wrong, from what it is taken to be off by in the blocks (K,)."""
    blocks = np.zeros(one.kept.shape)
    blocks[one.kept] = off_m**2
    seen = one.kept[..., 0]
    step = float(np.median(np.diff(one.block_s)))
    half = max(1, round(0.5 * MESH_WINDOW_S / step))

    def around(values: np.ndarray) -> np.ndarray:
        padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
        return np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1, axis=0).mean(-1)

    share = around(seen.astype(float))  # what was not seen says nothing of the mesh
    window = around(blocks.mean(-1)) / np.maximum(share, 1e-12)  # (B, M)
    near = share > 0.0
    alike = np.where(near, window, 0.0).sum(1, keepdims=True) / np.maximum(near.sum(1, keepdims=True), 1)
    spread = 0.5 * window + 0.5 * alike  # a marker that happens to agree is no better known
    error = np.repeat(np.sqrt(spread)[..., None], 3, axis=2)[one.kept]
    return np.hypot(error, MESH_FLOOR_M)
