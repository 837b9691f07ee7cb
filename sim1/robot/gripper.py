"""A gripper's openness, from its motor's angle and to its fingers' travel."""

import numpy as np

Q_MAX_RAD = 1.62  # mechanical limit of a finger joint (SIM1, eq. gripper_normalization)
FINGER_TRAVEL_M = 0.044  # of each finger from closed to fully open; limit of the finger joints in the URDF


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


def openness_from_travel(travel_m: np.ndarray) -> np.ndarray:
    """Openness in [0, 1] of a finger's travel in metres."""
    return np.clip(np.asarray(travel_m, float) / FINGER_TRAVEL_M, 0.0, 1.0)
