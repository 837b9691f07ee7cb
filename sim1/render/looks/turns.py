"""Turning about the vertical."""

import numpy as np


def about_z(angle_rad: float) -> np.ndarray:
    """Rotation (3, 3) about z, counter-clockwise from above: takes x to the direction with that bearing."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
