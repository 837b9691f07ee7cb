"""The colours that a fabric shows, without its relief."""

import numpy as np

from sim1.render.appearance import SCANNED, Color, Fabric
from sim1.render.looks.colors import encoded, linear
from sim1.render.looks.dyes import DYES
from sim1.render.looks.patterns import PATTERNS
from sim1.render.looks.weaves import weave_tile

SIZE_M = 0.6  # of the cloth whose mean is taken: about a garment
MEAN_POINTS = 72  # a side
TILE_POINTS = 128


def cloth_colors(fabric: Fabric, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Colour (..., 3) of pattern and dye, sRGB in [0, 1], at places in metres, the garment's middle at the origin."""
    cos, sin = np.cos(fabric.turn_rad), np.sin(fabric.turn_rad)
    u, v = cos * x + sin * y, cos * y - sin * x
    palette = np.array(fabric.colors)
    color = PATTERNS.make(fabric.pattern, u, v, fabric.seed) @ palette
    return np.clip(DYES.make(fabric.dye, color, u, v, palette, fabric.seed), 0.0, 1.0)


def shown_light(fabric: Fabric, measured: np.ndarray | None = None) -> np.ndarray:
    """Linear RGB (n, 3) that places all over the fabric show from afar, shade and weft of its weave included.

    Args:
        fabric: its look.
        measured: sRGB colours (n, 3) of places of the garment's texture, for the fabric SCANNED; without them its mean stands for it.
    """
    height, weft = weave_tile(fabric.weave, TILE_POINTS)
    if fabric.name == SCANNED:
        color = np.array(fabric.colors[:1]) if measured is None else measured
    else:
        place = (np.arange(MEAN_POINTS) + 0.5) * SIZE_M / MEAN_POINTS - 0.5 * SIZE_M
        color = cloth_colors(fabric, *np.meshgrid(place, place)).reshape(-1, 3)
    # Threads are far smaller than a pixel, which averages their light; the shade is given in sRGB, about the root of light.
    bright, over = (1.0 - fabric.shade * (1.0 - height)) ** 2, fabric.weft * weft
    own, of_weft = ((1.0 - over) * bright).mean(), (over * bright).mean()
    return own * linear(color) + of_weft * linear(fabric.colors[1])


def mean_color(fabric: Fabric) -> Color:
    """The sRGB colour of the fabric's mean light."""
    return tuple(encoded(shown_light(fabric).mean(axis=0)).tolist())
