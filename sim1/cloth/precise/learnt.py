"""What the steps of an iteration teach about a matrix that was factorized elsewhere: limited-memory BFGS (Nocedal 1980).

A factor of another shape sends an iteration too far or not far enough along a few directions, above all those along which cloth is about to
buckle. How forces changed along the last steps says by how much, for the price of a few products of vectors.
"""

from collections import namedtuple

import numpy as np
from numba import njit

REMEMBERED = 4  # steps

Learnt = namedtuple(
    "Learnt",
    [
        "move",  # (K, n) steps
        "turn",  # (K, n) how the residual changed along each
        "weight",  # (K,) one over the product of both
        "count",  # (1,) how many there are, the oldest first
    ],
)


@njit(cache=True, nogil=True)
def nothing_learnt(size):
    """Room for steps of `size` numbers."""
    return Learnt(
        np.empty((REMEMBERED, size)), np.empty((REMEMBERED, size)), np.empty(REMEMBERED), np.zeros(1, np.int64)
    )


@njit(cache=True, nogil=True)
def forget(learnt):
    """Nothing is known of a new matrix."""
    learnt.count[0] = 0


@njit(cache=True, nogil=True)
def learn(learnt, share, change, before, after):
    """Remember a step of `-share * change` (V, 3) along which the residual went from `before` to `after`; one that bends down teaches nothing."""
    count = learnt.count[0]
    if count == REMEMBERED:
        count -= 1
        for k in range(count):
            learnt.move[k] = learnt.move[k + 1]
            learnt.turn[k] = learnt.turn[k + 1]
            learnt.weight[k] = learnt.weight[k + 1]
    move, turn = learnt.move[count], learnt.turn[count]
    moved, old, new = change.ravel(), before.ravel(), after.ravel()
    both = 0.0
    for i in range(len(move)):
        move[i] = -share * moved[i]
        turn[i] = new[i] - old[i]
        both += move[i] * turn[i]
    if both > 0.0:
        learnt.weight[count] = 1.0 / both
        count += 1
    learnt.count[0] = count


@njit(cache=True, nogil=True)
def corrected(learnt, change):
    """Take out of a residual (V, 3), in place, what the last steps say of it; returns how much of each, for `correct`."""
    flat, count = change.reshape(-1), learnt.count[0]
    shares = np.empty(count)
    for back in range(count):
        k = count - 1 - back
        shares[k] = learnt.weight[k] * np.dot(learnt.move[k], flat)
        flat -= shares[k] * learnt.turn[k]
    return shares


@njit(cache=True, nogil=True)
def correct(learnt, shares, change):
    """Put into the solution (V, 3) of what `corrected` has left, in place, what the last steps say of it."""
    flat = change.reshape(-1)
    for k in range(len(shares)):
        flat += (shares[k] - learnt.weight[k] * np.dot(learnt.turn[k], flat)) * learnt.move[k]
