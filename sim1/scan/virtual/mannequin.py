"""A mannequin of simple shape (lofted ellipses), and a garment put on it."""

import numpy as np

from sim1.scan.cloud import Shape
from sim1.scan.surface import closest_points
from sim1.scan.virtual.bodies import loft, tube

# Torso: height, depth position of the middle, half depth, half width (m).
TORSO = np.array([
    (0.700, -0.063, 0.100, 0.148), (0.800, -0.063, 0.112, 0.152), (0.900, -0.064, 0.116, 0.153),
    (1.000, -0.060, 0.115, 0.150), (1.100, -0.058, 0.113, 0.148), (1.220, -0.056, 0.110, 0.148),
    (1.300, -0.057, 0.108, 0.148), (1.360, -0.060, 0.098, 0.145), (1.400, -0.062, 0.086, 0.138),
    (1.430, -0.061, 0.072, 0.124), (1.455, -0.058, 0.060, 0.104), (1.478, -0.053, 0.051, 0.080),
    (1.500, -0.047, 0.047, 0.060), (1.530, -0.042, 0.046, 0.052), (1.620, -0.036, 0.046, 0.050),
])  # fmt: skip

ARM = np.array([(-0.060, 0.130, 1.410), (-0.046, 0.430, 1.065)])  # left shoulder and wrist (m)


def torso(sections: np.ndarray, levels: int = 60) -> Shape:
    """Tube through elliptic sections (height, middle, half depth, half width), smooth between them."""
    from scipy.interpolate import PchipInterpolator

    height = np.linspace(sections[0, 0], sections[-1, 0], levels)
    middle, depth, width = PchipInterpolator(sections[:, 0], sections[:, 1:])(height).T
    zero = np.zeros(levels)
    return loft(
        np.stack([middle, zero, height], axis=1),
        np.stack([depth, zero, zero], axis=1),
        np.stack([zero, width, zero], axis=1),
    )


def shirt_mannequin() -> list[Shape]:
    """Torso with neck, and two arms that hang at 45 degrees."""
    arms = [tube(np.linspace(*ARM * [1.0, side, 1.0], 12), np.linspace(0.046, 0.036, 12)) for side in (1, -1)]
    return [torso(TORSO), *arms]


def dressed(garment: Shape, parts: list[Shape], gap_m: float) -> Shape:
    """The garment with every vertex at least about `gap_m` outside of every part; nothing else is moved."""
    vertices = garment.vertices_m.astype(float)
    for _ in range(6):
        for part in parts:
            closest, face, _ = closest_points(vertices, part.vertices_m, part.faces)
            corners = part.vertices_m[part.faces[face]]
            normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            outside = ((vertices - closest) * normal).sum(axis=1)
            vertices += normal * np.maximum(gap_m - outside, 0.0)[:, None]
    return Shape(vertices_m=vertices, faces=garment.faces)
