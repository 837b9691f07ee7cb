"""Random functions of the plane, the same for the same seed on every call and for every subset of points."""

from statistics import NormalDist

import numpy as np

WRAP = 1 << 20  # lattice cells after which an unwrapped function repeats: farther than any garment or floor reaches
SPREAD = 0.75  # of gradient noise about its mean: larger ones would be cut off at 0 and 1
DEVIATION = 0.1625  # standard deviation of `clouds` with one octave, measured; its mean is 0.5
SLOPES = np.stack([f(np.arange(64) * 2.0 * np.pi / 64) for f in (np.cos, np.sin)], axis=-1)


def scatter(i: np.ndarray, j: np.ndarray, seed: int) -> np.ndarray:
    """A random number in [0, 1) for every cell (i, j) of a lattice; arrays of whole numbers of one shape."""
    return _hashed(_whole(i), _whole(j), seed) / 2.0**32


def clouds(x: np.ndarray, y: np.ndarray, seed: int, *, octaves: int = 1, wrap: int = WRAP) -> np.ndarray:
    """Smooth noise in [0, 1] with features of one unit, and finer ones of halved size and weight with more octaves.

    Args:
        x: coordinates, any shape.
        y: the same shape.
        seed: another seed gives another pattern.
        octaves: number of sizes.
        wrap: whole number of units after which the noise repeats in both directions.
    """
    total, weight = np.zeros(np.shape(x)), 0.0
    for octave in range(octaves):
        scale, share = 2**octave, 0.5**octave
        total += share * _smooth(x * scale, y * scale, seed + 101 * octave, wrap * scale)
        weight += share
    return total / weight


def level(share: float, *, octaves: int) -> float:
    """Level that about `share` of `clouds` lies above: near normal; none is above that of 0, all above that of 1."""
    if share in (0.0, 1.0):
        return 2.0 - 3.0 * share  # beyond the range of the noise and the softest of edges
    halved = 0.5 ** np.arange(octaves)
    return NormalDist(0.5, DEVIATION * np.hypot.reduce(halved) / halved.sum()).inv_cdf(
        1.0 - min(max(share, 1e-9), 1.0 - 1e-9)
    )


def covered(share: float, noise: np.ndarray, *, octaves: int, soft: float) -> np.ndarray:
    """1 on about `share` of the plane, 0 on the rest, smooth between; none of it at 0 and all at 1.

    Args:
        share: in [0, 1].
        noise: `clouds` with `octaves`.
        octaves: of the noise.
        soft: half the width of an edge, in units of the noise; below 0.5.
    """
    middle = level(share, octaves=octaves)
    return step(middle - soft, middle + soft, noise)


def _smooth(x: np.ndarray, y: np.ndarray, seed: int, wrap: int) -> np.ndarray:
    """Gradient noise: every lattice point has a slope of its own and the value 0.5."""
    i, j = np.floor(x), np.floor(y)
    u, v = x - i, y - j
    along, across = _ease(u), _ease(v)
    columns, rows = ([_whole((start + corner) % wrap) for corner in (0, 1)] for start in (i, j))

    def pull(a: int, b: int) -> np.ndarray:
        slope = _hashed(columns[a], rows[b], seed) % np.uint32(len(SLOPES))
        return SLOPES[slope, 0] * (u - a) + SLOPES[slope, 1] * (v - b)

    near, far = ((1.0 - across) * pull(a, 0) + across * pull(a, 1) for a in (0, 1))
    return np.clip(0.5 + SPREAD * (near + along * (far - near)), 0.0, 1.0)


def _whole(values: np.ndarray) -> np.ndarray:
    return np.asarray(values).astype(np.int32).astype(np.uint32)


def _hashed(i: np.ndarray, j: np.ndarray, seed: int) -> np.ndarray:
    mixed = i * np.uint32(0x9E3779B1)
    mixed ^= j * np.uint32(0x85EBCA77) + np.full(1, (seed * 0xC2B2AE3D) & 0xFFFFFFFF, np.uint32)
    for shift, factor in ((16, 0x7FEB352D), (15, 0x846CA68B)):
        mixed ^= mixed >> np.uint32(shift)
        mixed *= np.uint32(factor)
    mixed ^= mixed >> np.uint32(16)
    return mixed


def _ease(t: np.ndarray) -> np.ndarray:
    return t * t * t * (t * (6.0 * t - 15.0) + 10.0)


def step(low: float, high: float, value: np.ndarray) -> np.ndarray:
    """0 up to `low`, 1 from `high`, smooth between."""
    return _ease(np.clip((value - low) / (high - low), 0.0, 1.0))
