"""The relief of cloth: a function of place in threads, the same again after `REPEAT` threads.

Each kind gives height in [0, 1] and where the weft, the thread along x, lies on top (1) or below (0).
"""

import numpy as np

from sim1.render.looks.blocks import Block, Kinds, Whole
from sim1.render.looks.noise import clouds

REPEAT = 32  # threads: a multiple of every kind's own period
WIDTHS = Whole((2, 4, 8, 16))  # threads: what `REPEAT` is a multiple of
WEAVES = Kinds("weave")

type Relief = tuple[np.ndarray, np.ndarray]


def weave_tile(weave: Block, pixels: int) -> tuple[np.ndarray, np.ndarray]:
    """Height and weft of `REPEAT` by `REPEAT` threads, each (pixels, pixels), row 0 at y = 0."""
    place = (np.arange(pixels) + 0.5) * REPEAT / pixels
    x, y = np.meshgrid(place, place)
    return WEAVES.make(weave, x, y)


@WEAVES.kind()
def plain(x: np.ndarray, y: np.ndarray) -> Relief:
    """Over one, under one."""
    return _interlaced(x, y, (np.floor(x) + np.floor(y)) % 2 < 1)


@WEAVES.kind()
def basket(x: np.ndarray, y: np.ndarray) -> Relief:
    """Over two, under two, in pairs."""
    return _interlaced(x, y, (np.floor(x / 2) + np.floor(y / 2)) % 2 < 1)


@WEAVES.kind(over=Whole((1, 2, 3)))
def twill(x: np.ndarray, y: np.ndarray, *, over: float) -> Relief:
    """Diagonals; the warp lies over `over` of four threads (denim: 3)."""
    return _interlaced(x, y, (np.floor(x) + np.floor(y)) % 4 < over)


@WEAVES.kind(width=WIDTHS)
def herringbone(x: np.ndarray, y: np.ndarray, *, width: float) -> Relief:
    """Diagonals that turn every `width` threads."""
    i = np.floor(x) % (2 * width)
    return _interlaced(x, y, (np.floor(y) + np.minimum(i, 2 * width - 1 - i)) % 4 < 2)


@WEAVES.kind()
def satin(x: np.ndarray, y: np.ndarray) -> Relief:
    """Long floats: one crossing in eight."""
    return _interlaced(x, y, (np.floor(x) * 3 + np.floor(y)) % 8 >= 1)


@WEAVES.kind(width=Whole((1, 2, 4, 8, 16)))
def rib(x: np.ndarray, y: np.ndarray, *, width: float) -> Relief:
    """Ridges along y, `width` threads from one to the next."""
    fuzz = clouds(2.0 * x, 2.0 * y, 7, wrap=2 * REPEAT)
    return 0.85 * np.abs(np.sin(np.pi * x / width)) ** 0.7 + 0.15 * fuzz, np.zeros_like(x)


@WEAVES.kind()
def knit(x: np.ndarray, y: np.ndarray) -> Relief:
    """Columns of stitches, each a V."""
    lean = np.abs(2.0 * (x % 1.0) - 1.0)
    course = 0.5 + 0.5 * np.cos(2.0 * np.pi * (y - 0.6 * lean))
    return course * (0.35 + 0.65 * np.abs(np.sin(2.0 * np.pi * x))), np.zeros_like(x)


@WEAVES.kind(width=WIDTHS)
def waffle(x: np.ndarray, y: np.ndarray, *, width: float) -> Relief:
    """Square hollows between ridges, `width` threads wide."""
    u, v = (np.abs(2.0 * ((axis / width) % 1.0) - 1.0) for axis in (x, y))
    return np.maximum(u, v) ** 1.5, np.zeros_like(x)


@WEAVES.kind()
def pile(x: np.ndarray, y: np.ndarray) -> Relief:
    """Loops or fibres that stand up, without order."""
    return clouds(x, y, 11, octaves=2, wrap=REPEAT), np.zeros_like(x)


def _interlaced(x: np.ndarray, y: np.ndarray, warp_up: np.ndarray) -> Relief:
    """Round threads, the one on top seen."""
    return np.sin(np.pi * np.where(warp_up, x % 1.0, y % 1.0)), np.where(warp_up, 0.0, 1.0)
