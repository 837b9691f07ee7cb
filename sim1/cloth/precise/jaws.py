"""Grips that yield as a whole: a stiff jaw on a spring shifts by compliance times load, and all that it holds with it.

Every held vertex hangs on its jaw by a spring that hardly yields. Eliminating the jaw's shift couples the vertices of a grip, which no
banded matrix holds; as the coupling has rank three per grip, solutions of the uncoupled matrix are corrected for it (Woodbury).
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.band_solve import BLOCK, solve_many
from sim1.cloth.precise.lapack import solve, solve_any

GRIP_M_N = 5e-5  # compliance per vertex of a grip that "holds exactly": 5 um at 0.1 N


@njit(cache=True, nogil=True)
def grip_loads(x, net, target, held_on, compliance, load):
    """Force (G, 3) that the cloth pulls every grip with [N], whose jaw yields by `compliance` [m/N]."""
    load[:] = 0.0
    count = np.zeros(len(load))
    for h in range(len(net.held)):
        if held_on[h]:
            count[net.grip[h]] += 1.0
            for k in range(3):
                load[net.grip[h], k] += (x[net.held[h], k] - target[h, k]) / GRIP_M_N
    for g in range(len(load)):
        load[g] /= 1.0 + compliance * count[g] / GRIP_M_N


@njit(cache=True, nogil=True)
def grip_count(net):
    """How many grips there are."""
    return net.grip.max() + 1 if len(net.grip) else 0


@njit(cache=True, nogil=True)
def coupling(net, held_on, compliance, size):
    """Rows u (3 G, size) of the coupling - sum u u^T that yielding jaws add to the matrix; (0, size) where none yields."""
    grips = grip_count(net) if compliance > 0.0 else 0
    rows, count = np.zeros((3 * grips, size)), np.zeros(grips)
    if grips == 0:
        return rows
    for h in range(len(net.held)):
        if held_on[h]:
            count[net.grip[h]] += 1.0
    for h in range(len(net.held)):
        if held_on[h]:
            g = net.grip[h]
            weight = np.sqrt(compliance / (1.0 + compliance * count[g] / GRIP_M_N)) / GRIP_M_N
            for k in range(3):
                rows[3 * g + k, 3 * net.held[h] + k] = weight
    return rows


@njit(cache=True, nogil=True)
def solve_coupled(kind, band, full, pivot, rows, right):
    """Solve in place for each row of `right` (k, n) with the factor in `band` (`kind` 0) or `full` and the coupling `rows` (c, n)."""
    _solve(kind, band, full, pivot, right)
    if len(rows):
        answers = rows.copy()
        _solve(kind, band, full, pivot, answers)
        inner = np.eye(len(rows)) - rows @ answers.T
        right += np.linalg.solve(inner, rows @ right.T).T @ answers


@njit(cache=True, nogil=True)
def _solve(kind, band, full, pivot, right):
    if kind != 0:
        solve_any(full, pivot, right)
    elif len(right) > 1 and band.shape[1] > BLOCK:
        solve_many(band, right)
    else:
        solve(band, right)
