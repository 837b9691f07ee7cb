"""Patterns of cloth: how much of each of three colours (base, second, third) is at a place, in metres.

Woven patterns mix the colours of both threads, printed ones have one colour at a place. Every function gives weights (n, 3)
that add up to 1.
"""

import numpy as np

from sim1.render.looks.blocks import Kinds, Whole
from sim1.render.looks.noise import clouds, level, scatter
from sim1.render.looks.weights import weights

PERIOD = (0.002, 0.5)  # m
SHARE = (0.02, 0.98)
PATTERNS = Kinds("pattern")


@PATTERNS.kind()
def plain(x: np.ndarray, y: np.ndarray, seed: int) -> np.ndarray:
    """The base colour alone."""
    return weights(np.zeros(x.shape))


@PATTERNS.kind(colors=2, period_m=PERIOD, share=SHARE)
def stripes(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, share: float) -> np.ndarray:
    """Stripes along y; `share` of the cloth has the second colour."""
    return weights(_band(x / period_m, 0.0, share))


@PATTERNS.kind(colors=2, period_m=PERIOD, share=SHARE)
def checks(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, share: float) -> np.ndarray:
    """Warp and weft striped alike, mixed half and half where they cross: gingham."""
    return weights(0.5 * (_band(x / period_m, 0.0, share) + _band(y / period_m, 0.0, share)))


@PATTERNS.kind(colors=2, period_m=PERIOD, share=SHARE)
def grid(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, share: float) -> np.ndarray:
    """Lines of the second colour in both directions, each `share` of a period wide: windowpane."""
    return weights(np.maximum(_band(x / period_m, 0.0, share), _band(y / period_m, 0.0, share)))


@PATTERNS.kind(colors=3, period_m=PERIOD, broad=(0.1, 0.7), narrow=(0.01, 0.15))
def tartan(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, broad: float, narrow: float) -> np.ndarray:
    """Broad bands of the second colour with a narrow one of the third between two of them, in warp and weft."""
    threads = []
    for axis in (x, y):
        place = axis / period_m
        second = _band(place, 0.0, broad)
        third = _band(place, 0.5 * (1.0 + broad - narrow), narrow) + _band(place, 0.5 * (broad - narrow), narrow)
        threads.append(weights(second * (1.0 - third), third))
    return 0.5 * (threads[0] + threads[1])


@PATTERNS.kind(colors=2, period_m=PERIOD)
def houndstooth(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float) -> np.ndarray:
    """Four threads of each colour in warp and weft, in a two-over-two twill whose threads are thick enough to be seen."""
    i, j = (np.floor(8.0 * axis / period_m) for axis in (x, y))
    warp_up = (i + j) % 4 < 2
    return weights(np.where(warp_up, i % 8 < 4, j % 8 < 4).astype(float))


@PATTERNS.kind(colors=2, period_m=PERIOD, share=(0.02, 0.5))
def dots(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, share: float) -> np.ndarray:
    """Round dots in rows, every other row shifted by half a period; they cover `share` of the cloth."""
    u, v, _, _ = _cells(x, y, period_m)
    return weights((np.hypot(u, v) < np.sqrt(share / np.pi)).astype(float))


@PATTERNS.kind(colors=3, period_m=PERIOD, line=(0.0, 0.2))
def argyle(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, line: float) -> np.ndarray:
    """Lozenges of the second colour, and lines of the third across them, `line` of a period wide."""
    a, b = (x / period_m + y / (1.4 * period_m)), (x / period_m - y / (1.4 * period_m))
    lozenge = ((np.floor(a) + np.floor(b)) % 2 < 1).astype(float)
    thin = np.maximum(_band(a - 0.5, 0.0, line), _band(b - 0.5, 0.0, line))
    return weights(lozenge * (1.0 - thin), thin)


@PATTERNS.kind(colors=2, period_m=PERIOD, share=SHARE)
def chevron(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, share: float) -> np.ndarray:
    """Zigzag stripes across y."""
    rise = 0.5 * np.abs(2.0 * ((x / period_m) % 1.0) - 1.0)
    return weights(_band(y / period_m + rise, 0.0, share))


@PATTERNS.kind(colors=3, period_m=PERIOD, petals=Whole(range(3, 10)), radius=(0.1, 0.5))
def flowers(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, petals: float, radius: float) -> np.ndarray:
    """Scattered flowers of the second colour with a middle of the third, turned and sized at random, and leaves between."""
    u, v, i, j = _cells(x, y, period_m)
    size = radius * (0.6 + 0.4 * scatter(i, j, seed))
    room = np.clip(0.5 - size, 0.0, None)  # a flower stays within its cell
    u = u - room * (2.0 * scatter(i, j, seed + 1) - 1.0)
    v = v - room * (2.0 * scatter(i, j, seed + 2) - 1.0)
    angle = np.arctan2(v, u) + 2.0 * np.pi * scatter(i, j, seed + 3)
    distance = np.hypot(u, v)
    petal = distance < size * (0.6 + 0.4 * np.cos(petals * angle))
    middle = distance < 0.3 * size
    a, b, *cell = _cells(x + 0.5 * period_m, y + 0.25 * period_m, period_m)
    turn = 2.0 * np.pi * scatter(*cell, seed + 4)
    along, across = a * np.cos(turn) + b * np.sin(turn), b * np.cos(turn) - a * np.sin(turn)
    leaf = ((along / 0.22) ** 2 + (across / 0.07) ** 2 < 1.0) & ~petal
    return weights((petal & ~middle).astype(float), (middle | leaf).astype(float))


@PATTERNS.kind(colors=3, period_m=PERIOD, share=SHARE)
def blobs(x: np.ndarray, y: np.ndarray, seed: int, *, period_m: float, share: float) -> np.ndarray:
    """Irregular patches of the second and third colour, each over about half of `share`: camouflage."""
    half = 0.5 * share
    second, third = (
        clouds(x / period_m + 13.7 * k, y / period_m, seed + k, octaves=2) > level(half, octaves=2) for k in (0, 1)
    )
    return weights((second & ~third).astype(float), third.astype(float))


def _band(place: np.ndarray, start: float, width: float) -> np.ndarray:
    """1 in a band of `width` periods that begins `start` periods after each whole number."""
    return ((place - start) % 1.0 < width).astype(float)


def _cells(x: np.ndarray, y: np.ndarray, period_m: float) -> tuple[np.ndarray, ...]:
    """Place in a cell, both in [-0.5, 0.5), and the cell's indices; odd rows are shifted by half a cell."""
    j = np.floor(y / period_m)
    u = x / period_m + 0.5 * (j % 2)
    i = np.floor(u)
    return u - i - 0.5, y / period_m - j - 0.5, i, j
