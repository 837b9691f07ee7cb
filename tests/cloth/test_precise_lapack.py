"""Banded factors from compiled code against dense algebra."""

import numpy as np
import pytest

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
