"""Which vertices of a sheet answer to each other, and where each group of vertices finds its pairs."""

from itertools import pairwise

import numpy as np

from sim1.cloth.precise.mesh import Sheet


def pairs_of(sheet: Sheet) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Vertices (B, 2) i >= j that share a ring or a stencil, and places in it: of rings (R,), of stencils (S,), of faces (F, 3, 3).

    Of a ring or stencil with n nodes, which are sorted, n (n + 1) / 2 pairs follow one another: (0, 0), (1, 0), (1, 1), (2, 0), ...
    """
    stencils = sheet.stencils
    _, _, _, first, node = sheet.stars
    of_rings, of_stencils = _within(first, node), _within(stencils.first, stencils.node)
    low, high = sheet.faces[:, None, :], sheet.faces[:, :, None]
    of_faces = np.stack(np.broadcast_arrays(np.maximum(low, high), np.minimum(low, high)), axis=-1).reshape(-1, 2)
    count = len(sheet.material_m)
    keys = [pair[:, 1] * count + pair[:, 0] for pair in (of_rings, of_stencils, of_faces)]  # by columns, as a band is
    known, place = np.unique(np.concatenate(keys), return_inverse=True)
    rings, stencil, face = np.split(place.astype(np.int64), np.cumsum([len(keys[0]), len(keys[1])]))
    return np.stack([known % count, known // count], axis=1).astype(np.int64), (rings, stencil, face.reshape(-1, 3, 3))


def _within(first: np.ndarray, node: np.ndarray) -> np.ndarray:
    return np.concatenate(
        [node[begin + np.stack(np.tril_indices(end - begin), axis=1)] for begin, end in pairwise(first)]
    )
