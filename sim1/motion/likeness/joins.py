"""How abruptly a path changes where two of its parts meet, against how abruptly demonstrations change anywhere."""

import numpy as np

from sim1.episode import RATE_HZ

ORDERS = ("position", "velocity", "acceleration")
COMMON_SHARE = 0.95  # what 95 % of the demonstrations' own frames stay below is nothing unusual
REACH = 3  # frames on either side that the differences of third order need


def steps_at(values: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Steps (k, 3) across the gap before each of `frames` (k,), larger one of both arms.

    A step of order d is the d-th finite difference that spans the gap, at RATE_HZ; of the d of them, the largest one.

    Args:
        values: (n, 2, c) positions of both arms over time.
        frames: each at least REACH, at most n - REACH.
    """
    result = np.empty((len(frames), len(ORDERS)))
    for order in range(1, len(ORDERS) + 1):
        difference = np.linalg.norm(np.diff(values, n=order, axis=0), axis=-1).max(axis=-1) * RATE_HZ ** (order - 1)
        spanning = np.stack([difference[frames - 1 - shift] for shift in range(order)])
        result[:, order - 1] = spanning.max(axis=0)
    return result


def inner_frames(count: int) -> np.ndarray:
    """Every frame of a path of `count` frames at which `steps_at` can be asked."""
    return np.arange(REACH, count - REACH + 1)


def common_steps(paths: list[np.ndarray]) -> np.ndarray:
    """(3,) what COMMON_SHARE of all inner frames of `paths`, each (n, 2, c), stay below."""
    return np.quantile(
        np.concatenate([steps_at(path, inner_frames(len(path))) for path in paths]), COMMON_SHARE, axis=0
    )


def join_ratios(paths: list[np.ndarray], joins: list[list[int]], common: np.ndarray) -> np.ndarray:
    """(3,) step at a join over the common step: what COMMON_SHARE of all joins stay below.

    Args:
        paths: each (n, 2, c).
        joins: of each path, first frame of the later part; those nearer than REACH to an end are left out.
        common: (3,) of `common_steps`.
    """
    rows = []
    for path, frames in zip(paths, joins, strict=True):
        inside = np.array([frame for frame in frames if REACH <= frame <= len(path) - REACH], int)
        rows.append(steps_at(path, inside))
    return np.quantile(np.concatenate(rows), COMMON_SHARE, axis=0) / common
