"""What an iteration learns of a matrix from its own steps."""

import numpy as np
import pytest

from sim1.cloth.precise.learnt import REMEMBERED, correct, corrected, forget, learn, nothing_learnt

SIZE = 12


@pytest.fixture
def matrix(rng):
    root = rng.normal(size=(SIZE, SIZE))
    return root @ root.T + np.eye(SIZE)


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def answer(learnt, residual, old):
    change = residual.copy()
    shares = corrected(learnt, change)
    change[:] = np.linalg.solve(old, change.ravel()).reshape(-1, 3)
    correct(learnt, shares, change)
    return change


def step(learnt, matrix, change, share=1.0):
    moved = -share * change
    before = np.zeros_like(change)
    learn(learnt, share, change, before, (matrix @ moved.ravel()).reshape(-1, 3))
    return moved


def test_the_last_step_is_known_exactly_however_wrong_the_factor(rng, matrix):
    learnt, old = nothing_learnt(SIZE), np.diag(rng.uniform(0.1, 10.0, SIZE))
    for _ in range(2 * REMEMBERED):
        moved = step(learnt, matrix, rng.normal(size=(4, 3)), share=0.3)
    turned = (matrix @ moved.ravel()).reshape(-1, 3)
    assert np.allclose(answer(learnt, turned, old), moved, atol=1e-9)


def test_a_step_that_bends_down_teaches_nothing(rng):
    learnt, old = nothing_learnt(SIZE), np.eye(SIZE)
    residual = rng.normal(size=(4, 3))
    step(learnt, -np.eye(SIZE), rng.normal(size=(4, 3)))
    assert np.array_equal(answer(learnt, residual, old), residual)


def test_of_a_new_matrix_nothing_is_known(rng, matrix):
    learnt, old = nothing_learnt(SIZE), np.eye(SIZE)
    residual = rng.normal(size=(4, 3))
    step(learnt, matrix, rng.normal(size=(4, 3)))
    assert not np.allclose(answer(learnt, residual, old), residual)
    forget(learnt)
    assert np.array_equal(answer(learnt, residual, old), residual)


def test_an_iteration_that_learns_needs_fewer_steps_than_one_that_does_not(rng, matrix):
    old = matrix + 0.8 * matrix.trace() / SIZE * np.eye(SIZE)

    def steps(learns):
        learnt, x, load = nothing_learnt(SIZE), np.zeros((4, 3)), np.linspace(1.0, 2.0, SIZE).reshape(4, 3)
        residual = -load
        for count in range(500):
            change = answer(learnt, residual, old)
            if np.abs(change).max() < 1e-8:
                return count
            x -= change
            before, residual = residual, (matrix @ x.ravel()).reshape(4, 3) - load
            if learns:
                learn(learnt, 1.0, change, before, residual)
        return count

    assert steps(learns=True) < 0.5 * steps(learns=False)
