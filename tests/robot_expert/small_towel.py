"""A towel small enough to be folded in seconds."""

import numpy as np

from sim1.cloth.garment import grid_towel

FABRIC = {
    "area_density_kg_m2": {"value": 0.3},
    "thickness_m": {"value": 0.002},
    "stretch_n_m": {"value": 400.0},
    "poisson": {"value": 0.3},
    "bending_n_m": {"value": 5.0e-5},
    "damping_s": {"value": 1.0e-3},
}
TOWEL = grid_towel(0.22, 0.30, 0.026)


def place(at: tuple[float, float, float]) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = at
    return pose
