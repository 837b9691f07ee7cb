"""The shape from which a simulation starts, as the first markers tell it."""

import warnings

import numpy as np
import pytest
from small_bundle import SIDE_M

from sim1.cloth.precise.mesh import square_sheet
from sim1.cloth.precise.start import spread_over

HANGING = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # (u, v) to (x, y, z)


@pytest.mark.parametrize("count", [3, 4, 5, 6, 16])
def test_few_markers_tell_where_a_flat_sheet_hangs(count):
    stream = np.random.default_rng(count)
    points, at = stream.uniform(0.0, SIDE_M, (count, 2)), square_sheet(4, SIDE_M).material_m
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = spread_over(points, points @ HANGING + 1e-4 * stream.standard_normal((count, 3)), at)
    assert np.abs(found - at @ HANGING).max() < 2e-3


def test_a_marker_that_is_not_seen_says_nothing():
    points = np.random.default_rng(0).uniform(0.0, SIDE_M, (6, 2))
    values = points @ HANGING
    values[2] = np.nan
    np.testing.assert_allclose(spread_over(points, values, points), points @ HANGING, atol=1e-6)
