"""The colours that a fabric shows, without its relief."""

import numpy as np

from sim1.render.appearance import SCANNED, Color, Fabric
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


def shown_colors(fabric: Fabric) -> np.ndarray:
    """Colours (n, 3) that places all over the fabric show from afar, shade and weft of its weave included."""
    height, weft = weave_tile(fabric.weave, TILE_POINTS)
    if fabric.name == SCANNED:
        color = np.array(fabric.colors[:1])
    else:
        place = (np.arange(MEAN_POINTS) + 0.5) * SIZE_M / MEAN_POINTS - 0.5 * SIZE_M
        color = cloth_colors(fabric, *np.meshgrid(place, place)).reshape(-1, 3)
    color = color + fabric.weft * weft.mean() * (np.array(fabric.colors[1]) - color)
    return color * (1.0 - fabric.shade * (1.0 - height.mean()))


def mean_color(fabric: Fabric) -> Color:
    """Mean sRGB colour that the fabric shows."""
    return tuple(shown_colors(fabric).mean(axis=0).tolist())
