"""A gripper's openness, from its motor's angle and to its fingers' travel, and how low they reach with it."""

import numpy as np

from sim1.cloth.config import CellConfig

Q_MAX_RAD = 1.62  # mechanical limit of a finger joint (SIM1, eq. gripper_normalization)
FINGER_TRAVEL_M = 0.044  # of each finger from closed to fully open; limit of the finger joints in the URDF
FINGER = CellConfig()  # its measures are the URDF's, whatever the settings of a cell


def openness_from_angle(q_finger_rad: np.ndarray) -> np.ndarray:
    """Openness in [0, 1], 1 is open, of motor angles of any shape: o = -clip(q / (2 q_max), -1, 0).

    The motor opens towards negative angles: 0 is closed, -2 q_max fully open (SIM1, eq. gripper_normalization).
    """
    return 0.0 - np.clip(np.asarray(q_finger_rad, float) / (2 * Q_MAX_RAD), -1.0, 0.0)


def angle_from_openness(openness: np.ndarray) -> np.ndarray:
    """Motor angle in rad of openness in [0, 1]; the inverse of `openness_from_angle` within the motor's range."""
    return -2 * Q_MAX_RAD * np.clip(np.asarray(openness, float), 0.0, 1.0)


def travel_from_openness(openness: np.ndarray) -> np.ndarray:
    """Travel in metres of each finger away from the middle; the tips are twice that apart."""
    return FINGER_TRAVEL_M * np.clip(np.asarray(openness, float), 0.0, 1.0)


def below_m(rotation: np.ndarray, openness: np.ndarray) -> np.ndarray:
    """How far [m] the fingers' lowest edge lies below the middle between their tips, of any shape (...).

    By half a finger's width, and by the outside of the lower one.

    Args:
        rotation: (..., 3, 3) tool to world.
        openness: (...) in [0, 1].
    """
    outside_m = travel_from_openness(openness) + FINGER.finger_thickness_m
    return 0.5 * FINGER.finger_width_m * np.abs(rotation[..., 2, 2]) + outside_m * np.abs(rotation[..., 2, 1])
