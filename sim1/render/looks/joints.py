"""How a table top or a floor is divided: which piece a place belongs to, and the gaps between pieces.

Every function gives the piece's two indices and whether it lies in a gap; places are in metres.
"""

import numpy as np

from sim1.render.looks.blocks import Kinds

LENGTH = (0.01, 5.0)  # m
GAP = (0.0, 0.02)  # m
JOINTS = Kinds("joints")

type Pieces = tuple[np.ndarray, np.ndarray, np.ndarray]


@JOINTS.kind()
def none(x: np.ndarray, y: np.ndarray) -> Pieces:
    """One piece."""
    return np.zeros(x.shape), np.zeros(x.shape), np.zeros(x.shape, bool)


@JOINTS.kind(width_m=LENGTH, length_m=LENGTH, gap_m=GAP)
def planks(x: np.ndarray, y: np.ndarray, *, width_m: float, length_m: float, gap_m: float) -> Pieces:
    """Boards along x, each row shifted against the one beside it."""
    row = np.floor(y / width_m)
    along = x + length_m * ((0.382 * row) % 1.0)
    return np.floor(along / length_m), row, _gap(along, length_m, gap_m) | _gap(y, width_m, gap_m)


@JOINTS.kind(width_m=LENGTH, length_m=LENGTH, gap_m=GAP)
def tiles(x: np.ndarray, y: np.ndarray, *, width_m: float, length_m: float, gap_m: float) -> Pieces:
    """A grid."""
    gap = _gap(x, length_m, gap_m) | _gap(y, width_m, gap_m)
    return np.floor(x / length_m), np.floor(y / width_m), gap


def _gap(place: np.ndarray, pitch_m: float, gap_m: float) -> np.ndarray:
    return place % pitch_m < gap_m
