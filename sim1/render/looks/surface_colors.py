"""The colours that a table top or a floor shows."""

import numpy as np

from sim1.render.appearance import Color, Surface
from sim1.render.looks.colors import encoded, linear
from sim1.render.looks.figures import FIGURES
from sim1.render.looks.joints import JOINTS
from sim1.render.looks.noise import scatter

GAP_SHADE = 0.45  # brightness of a gap, of that of the pieces beside it
PIECE_M = 7.3  # pieces are cut from places of one figure that far apart
SIZE_M = (0.8, 1.2)  # of the surface whose mean is taken: about a table
MEAN_POINTS = (48, 72)


def surface_colors(surface: Surface, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Colour (..., 3), sRGB in [0, 1], at places in metres."""
    i, j, gap = JOINTS.make(surface.joints, x, y)
    shift = PIECE_M * np.floor(64.0 * scatter(i, j, surface.seed))
    weights = FIGURES.make(surface.figure, x + shift, y + shift, surface.seed)
    bright = (1.0 + surface.tone * (2.0 * scatter(i, j, surface.seed + 1) - 1.0)) * np.where(gap, GAP_SHADE, 1.0)
    return np.clip(weights @ np.array(surface.colors) * bright[..., None], 0.0, 1.0)


def mean_color(surface: Surface) -> Color:
    """The sRGB colour of the surface's mean light."""
    places = [(np.arange(count) + 0.5) * size / count - 0.5 * size for size, count in zip(SIZE_M, MEAN_POINTS)]
    return tuple(encoded(linear(surface_colors(surface, *np.meshgrid(*places))).mean(axis=(0, 1))).tolist())
