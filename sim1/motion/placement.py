"""Where a garment lies: random rigid placements on the table, and the placement that a deformed garment has now."""

import numpy as np


def planar(translation_m: np.ndarray, angle_rad: float, centre_m: np.ndarray) -> np.ndarray:
    """(4, 4) rotation about the vertical through `centre_m`, then translation (2,) on the table."""
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    result = np.eye(4)
    result[:2, :2] = [[c, -s], [s, c]]
    result[:2, 3] = centre_m[:2] - result[:2, :2] @ centre_m[:2] + translation_m
    return result


def random_placement(rng: np.random.Generator, radius_m: float, angle_rad: float, centre_m: np.ndarray) -> np.ndarray:
    """(4, 4): translation uniform in a disc, rotation uniform within +- `angle_rad` about `centre_m`."""
    direction, distance = rng.uniform(0, 2 * np.pi), radius_m * np.sqrt(rng.uniform())
    turn = rng.uniform(-angle_rad, angle_rad)
    return planar(distance * np.array([np.cos(direction), np.sin(direction)]), turn, centre_m)


def fitted_placement(before_m: np.ndarray, now_m: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """(4, 4) rigid motion on the table that takes `before_m` (v, 3) nearest to `now_m`, weighted least squares.

    Heights stay: a grasp height belongs to the table. Source: Kabsch 1976, in the plane.
    """
    share = weight / weight.sum()
    middle_before, middle_now = share @ before_m[:, :2], share @ now_m[:, :2]
    a, b = before_m[:, :2] - middle_before, now_m[:, :2] - middle_now
    cosine = (share[:, None] * a * b).sum()
    sine = (share * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])).sum()
    return planar(middle_now - middle_before, np.arctan2(sine, cosine), middle_before)


def grasp_weight(garment_m: np.ndarray, grasps: list[int], reach_m: float) -> np.ndarray:
    """(v,) weight that fades with the distance from the grasped vertices; even where nothing is grasped."""
    floor = 0.05  # the rest of the garment keeps the fit steady where few vertices are near
    if not grasps:
        return np.ones(len(garment_m))
    distance = np.linalg.norm(garment_m[:, None] - garment_m[grasps], axis=-1).min(axis=1)
    return floor + np.exp(-((distance / reach_m) ** 2))


def unplaced(garment_m: np.ndarray, start_m: np.ndarray) -> np.ndarray:
    """A garment's motion (T, v, 3) seen from the place where it would have started at `start_m` (v, 3).

    Judges and rules speak of fold lines and extents along the table's axes; a garment that was laid down turned is looked at
    as if it had not been.
    """
    first = np.asarray(garment_m[0], float)
    back = fitted_placement(first, start_m, np.ones(len(first)))
    return garment_m @ back[:3, :3].T + back[:3, 3]
