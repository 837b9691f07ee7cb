"""Twins of a sheet solved for with one banded factor: all at once in blocks, against LAPACK's one after the other."""

from typing import Any

import numpy as np

from benchmarks.timing import against
from sim1.cloth.precise.band_solve import solve_many
from sim1.cloth.precise.lapack import factor, solve

SIZE, WIDTH = 1323, 134  # of a sheet of 21 x 21 vertices
TWINS = 12


def compare() -> dict[str, Any]:
    """A dozen right sides."""
    stream = np.random.default_rng(0)
    band = stream.standard_normal((SIZE, WIDTH + 1)) / (2 * WIDTH)
    band[:, 0] = 1.5
    factor(band)
    right = stream.standard_normal((TWINS, SIZE))
    return against(
        f"{TWINS} right sides for a band of {SIZE} x {WIDTH + 1}, in blocks",
        lambda: solve_many(band, right.copy()),
        "LAPACK's dpbtrs",
        lambda: solve(band, right.copy()),
    )
