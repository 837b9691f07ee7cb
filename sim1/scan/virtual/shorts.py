"""Shorts of the project's own shape, on hips with two legs."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.virtual.bodies import tube
from sim1.scan.virtual.implicit import cut, ellipse, union, zero_set
from sim1.scan.virtual.mannequin import dressed, torso

_WAIST_M, _HEM_M = 1.02, 0.63
# Hips: height, depth position of the middle, half depth, half width (m).
_HIPS = np.array([(0.825, 0.0, 0.080, 0.14), (0.85, 0.0, 0.098, 0.160), (0.90, 0.0, 0.106, 0.170), (0.97, 0.0, 0.100, 0.160), (1.20, 0.0, 0.095, 0.145)])  # fmt: skip


def hips() -> list[Shape]:
    """Mannequin: hips with two legs, a little apart."""
    legs = [
        tube(np.linspace([0.0, side * 0.095, 0.86], [0.0, side * 0.205, 0.42], 14), np.linspace(0.085, 0.060, 14))
        for side in (1, -1)
    ]
    return [torso(_HIPS), *legs]


def shorts_shape() -> Shape:
    """Three openings: waist and two legs; creases around the legs."""

    def field(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        hip = ellipse(
            x,
            y,
            np.interp(z, [0.80, 0.90, 1.02], [0.112, 0.121, 0.112]),
            np.interp(z, [0.80, 0.90, 1.02], [0.172, 0.187, 0.168]),
        )
        hip = np.maximum(hip, 0.80 - z)
        legs = []
        for side in (1, -1):
            across = side * y - (0.10 + 0.25 * (0.86 - z))
            flare = 0.07 * (0.86 - z)
            legs.append(np.maximum(ellipse(x, across, 0.100 + flare, 0.090 + flare), z - 0.88))
        crease = 0.0022 * np.sin(55 * z + 18 * x + 6 * np.abs(y)) * np.clip((0.86 - z) / 0.1, 0, 1)
        return union(hip, *legs, blend_m=0.012) - crease

    closed = zero_set(field, (-0.2, -0.3, 0.56), (0.2, 0.3, 1.09))
    open_waist = cut(closed, (0.0, 0.0, _WAIST_M), (0.0, 0.0, -1.0))
    return dressed(cut(open_waist, (0.0, 0.0, _HEM_M), (0.0, 0.0, 1.0)), hips(), gap_m=0.003)


def shorts_color(points: np.ndarray) -> np.ndarray:
    """Navy with a light waistband, a red side stripe and a check."""
    x, y, z = points.T
    rgb = np.where(((z * 1000 // 25 + np.floor(x * 1000 / 25)) % 2 == 0)[:, None], (44, 56, 98), (58, 74, 122))
    rgb = np.where(((np.abs(x) < 0.012) & (np.abs(y) > 0.12))[:, None], (208, 52, 48), rgb)
    return np.where((z > _WAIST_M - 0.035)[:, None], (196, 200, 208), rgb)
