"""Springs from markers to their goals in the compiled loops: their forces, and what they add to the matrix."""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import PULL_DAMPING, PULL_STIFFNESS
from sim1.cloth.precise.compiled_code import FLAGS


@njit(cache=True, nogil=True, fastmath=FLAGS)
def pull(x, v, net, scalar, goal, goal_v, force, out):
    """Springs and dampers from markers to their goals; their forces go to `force` (M, 3)."""
    for m in range(len(net.marker_node)):
        for k in range(3):
            force[m, k] = 0.0
            if np.isnan(goal[m, k]):
                continue
            place = speed = 0.0
            for a in range(3):
                place += net.marker_weight[m, a] * x[net.marker_node[m, a], k]
                speed += net.marker_weight[m, a] * v[net.marker_node[m, a], k]
            force[m, k] = scalar[PULL_STIFFNESS] * (goal[m, k] - place) + scalar[PULL_DAMPING] * (goal_v[m, k] - speed)
            for a in range(3):
                out[net.marker_node[m, a], k] -= net.marker_weight[m, a] * force[m, k]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def pull_slope(net, scalar, goal, rate, band):
    """Add to the matrix `band` what the springs and dampers answer, where velocity grows with the place at `rate`."""
    stiffness = scalar[PULL_STIFFNESS] + scalar[PULL_DAMPING] * rate
    for m in range(len(net.marker_node)):
        if np.isnan(goal[m, 0]):
            continue
        for a in range(3):
            i = net.marker_node[m, a]
            for b in range(3):
                j = net.marker_node[m, b]
                if i >= j:
                    for k in range(3):
                        band[3 * j + k, 3 * (i - j)] += net.marker_weight[m, a] * net.marker_weight[m, b] * stiffness
