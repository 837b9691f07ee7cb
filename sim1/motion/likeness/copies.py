"""Whether a generated movement is a demonstrated one over again."""

import numpy as np

COPY_SHARE = 0.1  # of the smallest distance between two demonstrations: nearer than this is a copy


def nearest_distances(shapes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Root mean square distance (k,) of each of `shapes` (k, 2, n, 3) to the nearest of `others` (m, 2, n, 3)."""
    apart = shapes[:, None] - others[None]
    return np.sqrt((apart**2).sum(axis=-1).mean(axis=(-1, -2))).min(axis=1)


def nearest_of_the_rest(shapes: np.ndarray) -> np.ndarray:
    """Distance (k,) of each of `shapes` (k, 2, n, 3), k > 1, to the nearest of the others among them."""
    return np.array([nearest_distances(shapes[[i]], np.delete(shapes, i, axis=0))[0] for i in range(len(shapes))])
