"""Markers on the cloth and what cameras make of them."""

from dataclasses import dataclass

import numpy as np

from benchmarks.concealed.cloth import Grid
from benchmarks.concealed.setting import Setting


@dataclass(frozen=True)
class Markers:
    """M painted points."""

    uv_m: np.ndarray
    """(M, 2) material coordinates."""
    weights: np.ndarray
    """(M, count) cubic interpolation on the grid's flat axis: the place of a point on a smooth sheet."""


def draw_markers(setting: Setting, grid: Grid, rng: np.random.Generator) -> Markers:
    """25 to 49 points: a jittered net, so that no part of the cloth goes unseen."""
    across, down = (int(n) for n in rng.integers(5, 8, 2))
    cell_u, cell_v = setting.cloth.size_u_m / across, setting.cloth.size_v_m / down
    column, row = (axis.ravel() for axis in np.meshgrid(np.arange(across), np.arange(down)))
    u = (column + 0.5 + rng.uniform(-0.35, 0.35, len(column))) * cell_u
    v = (row + 0.5 + rng.uniform(-0.35, 0.35, len(row))) * cell_v
    uv = np.stack([u, v], axis=1)
    return Markers(uv, cubic_weights(grid, uv))


def cubic_weights(grid: Grid, uv_m: np.ndarray) -> np.ndarray:
    """(M, count) Lagrange weights on the 4 x 4 vertices around each point (shifted inwards at the rim)."""
    out = np.zeros((len(uv_m), grid.count))
    for marker, (u, v) in enumerate(uv_m):
        first_u, along_u = _lagrange(u / grid.du_m, grid.columns)
        first_v, along_v = _lagrange(v / grid.dv_m, grid.rows)
        for i, a in enumerate(along_v):
            start = grid.at(first_v + i, first_u)
            out[marker, start : start + 4] = a * along_u
    return out


def _lagrange(place: float, count: int) -> tuple[int, np.ndarray]:
    """First of four nodes and the weights of the cubic through them, at a place in spacings."""
    first = int(np.clip(np.floor(place) - 1, 0, count - 4))
    s, nodes = place - first, np.arange(4)
    return first, np.array(
        [np.prod([(s - m) / (n - m) for m in nodes if m != n]) for n in nodes],
    )


def camera_noise(shape: tuple[int, int, int], rate_hz: float, rms_m: float, rng: np.random.Generator) -> np.ndarray:
    """(F, M, 3) white, heavy-tailed (Student's t, 3 degrees) and slowly wandering parts; rms_m over all, in expectation."""
    frames = shape[0]
    share = np.array([rng.uniform(0.4, 0.7), rng.uniform(0.1, 0.25), rng.uniform(0.1, 0.3)])
    share = np.sqrt(share / share.sum())
    white = rng.normal(size=shape)
    heavy = np.clip(rng.standard_t(3, size=shape), -12, 12) / np.sqrt(3)
    keep = np.exp(-1 / (rate_hz * rng.uniform(0.05, 0.25)))
    wander = np.empty(shape)
    wander[0] = rng.normal(size=shape[1:])
    kicks = rng.normal(size=shape) * np.sqrt(1 - keep**2)
    for frame in range(1, frames):
        wander[frame] = keep * wander[frame - 1] + kicks[frame]
    return rms_m * (share[0] * white + share[1] * heavy + share[2] * wander)


def drop_outs(frames: int, markers: int, rng: np.random.Generator) -> np.ndarray:
    """(F, M) visible or not: each marker is lost a few times for a few frames."""
    visible = np.ones((frames, markers), dtype=bool)
    for marker in range(markers):
        for _ in range(rng.poisson(1.2)):
            start, length = rng.integers(0, frames), 2 + rng.geometric(0.15)
            visible[start : start + length, marker] = False
    return visible
