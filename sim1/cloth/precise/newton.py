"""One step of the base: Newton's method with a line search, on a banded matrix that is factorized as seldom as possible."""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import BASE, COMPLIANCE, DEFINITE, PULL_STIFFNESS
from sim1.cloth.precise.compiled_code import FLAGS
from sim1.cloth.precise.forces import residual
from sim1.cloth.precise.jaws import coupling, solve_coupled
from sim1.cloth.precise.lapack import factor
from sim1.cloth.precise.learnt import correct, corrected, forget, learn, nothing_learnt
from sim1.cloth.precise.pull_forces import pull, pull_slope
from sim1.cloth.precise.smooth_push import smooth_push, smooth_push_slope
from sim1.cloth.precise.stiffness import derivative

LONGEST_M = 0.1  # a Newton step moves no vertex further
FACTOR_COSTS = 8  # iterations: an old factor is kept while so many more by it come to an end
LEAST = 2  # before that is asked: what the first steps teach shortens the way


@njit(cache=True, nogil=True)
def newton(
    x, hv, ha, rate, mass_rate, sliding, net, cloth, curvature, moment, crease, target, held_on,
    tolerance, most, goal, goal_v, known, band, out, force,
):  # fmt: skip
    """Solve a step of the base in place, with a line search that asks forces alone. Returns the last change [m].

    Negative: not converged, by so much; -inf: no matrix could be factorized or nothing is finite any more. `out` (V, 3) is left with
    the residual and `force` (M, 3) with the pull on the markers, both before that change. `known`: `band` holds a factor of a similar
    shape, and is used while `Learnt` can make up for what it gets wrong.
    """
    change, before = np.zeros_like(x), np.zeros_like(x)
    v, acc = np.empty_like(x), np.empty_like(x)
    last, size, share, first = 1e30, 1e30, 1.0, 0.0
    old, fresh = not known, True
    trial = searches = 0
    learnt = nothing_learnt(x.size)
    rows, nowhere = coupling(net, held_on, cloth.scalar[0, COMPLIANCE], x.size), np.empty(0, np.int32)
    while True:
        x -= share * change
        v[:] = rate * x + hv
        acc[:] = mass_rate * x + ha
        residual(x, v, acc, sliding, net, cloth, BASE, curvature, moment, crease, target, held_on, out)
        if cloth.scalar[0, PULL_STIFFNESS] > 0.0:
            pull(x, v, net, cloth.scalar[0], goal, goal_v, force, out)
        smooth_push(v, cloth.push, BASE, out)
        if not fresh:
            slope = _dot(out, change)
            if slope < -0.6 * first and size * share > 10.0 * tolerance and searches < 5:
                x += share * change  # the valley lies well behind: back to where the secant puts it
                share *= min(max(first / (first - slope), 0.1), 0.7)
                searches += 1
                continue
            slow = trial > LEAST and size * (size / last) ** FACTOR_COSTS > tolerance
            old = share < 0.99 or slow or trial > 10
            last = 1e30 if old else size
            if trial >= most:
                return -size
            learn(learnt, share, change, before, out)
        if old:
            for careful in range(2):
                tension_only = careful == 1 or trial > most // 2
                derivative(
                    x, v, mass_rate, rate, sliding, net, cloth, curvature, moment, held_on, tension_only, band
                )  # fmt: skip
                if cloth.scalar[0, PULL_STIFFNESS] > 0.0:
                    pull_slope(net, cloth.scalar[0], goal, rate, band)
                smooth_push_slope(cloth.push, rate, band)
                failed = factor(band)
                if failed == 0:
                    break
            if failed != 0:
                return -np.inf
            old = False
            forget(learnt)
        before[:] = out
        change[:] = out
        shares = corrected(learnt, change)
        solve_coupled(DEFINITE, band, band, nowhere, rows, change.reshape(1, -1))
        correct(learnt, shares, change)
        size = largest(change.ravel())
        if not size < 1e3:
            return -np.inf
        if size < tolerance:
            x -= change
            return size
        share = min(1.0, LONGEST_M / max(size, 1e-12))
        first = _dot(out, change)
        fresh, searches = False, 0
        trial += 1


@njit(cache=True, nogil=True, fastmath=FLAGS)
def largest(change):
    """Largest magnitude of numbers (n,); NaN if one of them is."""
    most = 0.0
    for value in change:
        size = abs(value)
        if size > most:
            most = size
        elif not size <= most:
            return np.nan
    return most


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _dot(a, b):
    total = 0.0
    for i in range(a.shape[0]):
        for k in range(3):
            total += a[i, k] * b[i, k]
    return total


@njit(cache=True, nogil=True, fastmath=FLAGS)
def net_width(net):
    """Largest difference between vertices that share a face or a stencil."""
    most = 0
    for f in range(len(net.faces)):
        for a in range(3):
            for b in range(3):
                most = max(most, abs(net.faces[f, a] - net.faces[f, b]))
    for c in range(len(net.first) - 1):
        low, high = len(net.node) * 1000, 0
        for a in range(net.first[c], net.first[c + 1]):
            low, high = min(low, net.node[a]), max(high, net.node[a])
        most = max(most, high - low)
    for i in range(len(net.ring_first) - 1):
        low, high = len(net.node) * 1000, 0
        for a in range(net.ring_first[i], net.ring_first[i + 1]):
            low, high = min(low, net.ring_node[a]), max(high, net.ring_node[a])
        most = max(most, high - low)
    return most
