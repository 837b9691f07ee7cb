"""Banded factors from compiled code against dense algebra."""

import numpy as np
import pytest

from sim1.cloth.precise.band_solve import BLOCK, solve_many
from sim1.cloth.precise.lapack import factor, factor_any, solve, solve_any

SIZE, WIDTH = 12, 3


@pytest.fixture
def symmetric():
    """A symmetric matrix of full rank, (n, n), its band `[j, i - j]` and right sides (k, n)."""
    stream = np.random.default_rng(0)
    full = np.zeros((SIZE, SIZE))
    for away in range(WIDTH + 1):
        diagonal = stream.standard_normal(SIZE - away)
        full += np.diag(diagonal, -away) + (np.diag(diagonal, away) if away else 0.0)
    return full, stream.standard_normal((4, SIZE))


def banded(full):
    band = np.zeros((SIZE, WIDTH + 1))
    for j in range(SIZE):
        for i in range(j, min(j + WIDTH + 1, SIZE)):
            band[j, i - j] = full[i, j]
    return band


def test_a_positive_definite_matrix_is_solved(symmetric):
    full, right = symmetric
    full = full + 10.0 * np.eye(SIZE)
    band, found = banded(full), right.copy()
    assert factor(band) == 0
    solve(band, found)
    np.testing.assert_allclose(found, np.linalg.solve(full, right.T).T, rtol=1e-10)


def test_an_indefinite_matrix_is_refused_by_cholesky_and_solved_with_pivots(symmetric):
    full, right = symmetric
    assert np.linalg.eigvalsh(full)[0] < 0
    band, found = banded(full), right.copy()
    room, pivot = np.empty((SIZE, 3 * WIDTH + 1)), np.empty(SIZE, np.int32)
    assert factor(band.copy()) > 0
    assert factor_any(band, room, pivot) == 0
    solve_any(room, pivot, found)
    np.testing.assert_allclose(found, np.linalg.solve(full, right.T).T, rtol=1e-10)


def test_a_singular_matrix_is_refused():
    room, pivot = np.empty((SIZE, 3 * WIDTH + 1)), np.empty(SIZE, np.int32)
    assert factor_any(np.zeros((SIZE, WIDTH + 1)), room, pivot) > 0


@pytest.mark.parametrize("size", [1, BLOCK, BLOCK + 1, 3 * BLOCK - 5, 200])
@pytest.mark.parametrize("width", [BLOCK, BLOCK + 1, 2 * BLOCK, 100])
@pytest.mark.parametrize("count", [1, 13])
def test_many_right_sides_at_once_are_solved_as_each_is_alone(size, width, count):
    """Sizes around those at which blocks end, a band narrower and wider than the matrix, and junk in what no matrix has."""
    stream = np.random.default_rng(1)
    band = stream.standard_normal((size, width + 1)) / (2 * width)
    band[:, 0] = 1.5
    right = stream.standard_normal((count, size))
    assert factor(band) == 0
    one_by_one, at_once = right.copy(), right.copy()
    solve(band, one_by_one)
    solve_many(band, at_once)
    np.testing.assert_allclose(at_once, one_by_one, rtol=1e-12, atol=1e-14)
