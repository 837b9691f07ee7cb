"""How a place is shared among the three colours of a palette."""

import numpy as np


def weights(second: np.ndarray, third: np.ndarray | float = 0.0) -> np.ndarray:
    """Weights (..., 3) of base, second and third colour, which add up to 1."""
    third = np.broadcast_to(third, second.shape)
    return np.stack([1.0 - second - third, second, third], axis=-1)
