"""A polo shirt of the project's own shape: stand collar, raised placket, wide body."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.virtual.implicit import cut, ellipse, union, zero_set
from sim1.scan.virtual.mannequin import ARM, TORSO, dressed, shirt_mannequin

_HEM_M, _COLLAR_M, _SLEEVE_M = 0.86, 1.535, 0.21  # heights; sleeve length along the arm
_SHOULDER, _DIRECTION = ARM[0], (ARM[1] - ARM[0]) / np.linalg.norm(ARM[1] - ARM[0])


def polo_shape() -> Shape:
    """Four openings: collar, two sleeves, hem."""
    loose = np.interp(TORSO[:, 0], [0.8, 1.3, 1.42, 1.49, 1.50, 1.54], [0.024, 0.020, 0.012, 0.009, 0.011, 0.022])

    def field(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        middle, depth, width, slack = (np.interp(z, TORSO[:, 0], column) for column in (*TORSO[:, 1:].T, loose))
        body = ellipse(x - middle, y, depth + slack, width + slack)
        sleeves = [_sleeve(points * [1.0, side, 1.0]) for side in (1, -1)]
        folds = 0.0025 * np.sin(38 * y + 7 * np.sin(9 * z)) * np.clip((1.32 - z) / 0.2, 0, 1)
        placket = 0.0012 / (1 + np.exp((np.abs(y) - 0.018) / 0.0012)) / (1 + np.exp((1.32 - z) / 0.002)) * (x > -0.02)
        return union(body, *sleeves, blend_m=0.010) - folds - placket

    shape = zero_set(field, (-0.26, -0.42, 0.80), (0.15, 0.42, 1.60))
    shape = cut(shape, (0.0, 0.0, _HEM_M), (0.0, 0.0, 1.0))
    shape = cut(shape, (-0.04, 0.0, _COLLAR_M), (-0.20, 0.0, -1.0))
    for side in (1, -1):
        mirror = np.array([1.0, side, 1.0])
        end, back = (_SHOULDER + _SLEEVE_M * _DIRECTION) * mirror, -_DIRECTION * mirror
        shape = cut(shape, tuple(end), tuple(back), beyond_y_m=0.19, side=side)
    return dressed(shape, shirt_mannequin(), gap_m=0.003)


def _sleeve(points: np.ndarray) -> np.ndarray:
    offset = points - _SHOULDER
    along = offset @ _DIRECTION
    across = offset - along[:, None] * _DIRECTION
    upper = np.cross(_DIRECTION, [1.0, 0.0, 0.0])
    tube = ellipse(across[:, 0], across @ upper, 0.062 + 0.03 * along, 0.060 + 0.05 * along)
    return np.maximum(tube, -along)


def polo_color(points: np.ndarray) -> np.ndarray:
    """Red pique with a white collar, cuffs, and buttons on the placket."""
    x, y, z = points.T
    rgb = np.where((np.floor(z * 1000 / 8) % 2 == 0)[:, None], (176, 40, 52), (188, 48, 60))
    along = (np.stack([x, np.abs(y), z], axis=1) - _SHOULDER) @ _DIRECTION
    rgb = np.where(((along > _SLEEVE_M - 0.02) & (np.abs(y) > 0.17) & (z > 1.18))[:, None], (236, 236, 232), rgb)
    front = (np.abs(y) < 0.018) & (x > -0.02) & (z > 1.32)
    rgb = np.where(front[:, None], (150, 28, 40), rgb)
    button = front & (y**2 + ((z - 1.34) % 0.05 - 0.02) ** 2 < 0.006**2)
    return np.where((button | (z > 1.495))[:, None], (236, 236, 232), rgb)
