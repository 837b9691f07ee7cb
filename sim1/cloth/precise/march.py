"""Time steps of the base and its twins: BDF2.

BDF2 is second order and does not damp slow swings: at 1 Hz and h = 1/60 s it loses 0.1 % a period, implicit Euler a third.
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.compiled_code import FLAGS
from sim1.cloth.precise.memory import remember, settle, slip, targets_at, targets_of
from sim1.cloth.precise.newton import net_width, newton
from sim1.cloth.precise.twins import answers, keep_near, matrix, solved

SLIDING_M_S = 3e-4  # friction is regularised below this speed: what creeps must not look like sticking friction
# How a step is tried: factor of that speed, most iterations, whether from the last shape. Where cloth that stuck comes off the table
# friction jumps nearly: it is then found softened first, and each time from there a little sharper.
TRIES = (
    (1.0, 40, False),
    (1.0, 120, True),
    (100.0, 120, True),
    (30.0, 60, False),
    (10.0, 60, False),
    (3.0, 60, False),
    (1.0, 120, False),
)


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _markers(x, net, out):
    for m in range(len(net.marker_node)):
        for k in range(3):
            out[m, k] = 0.0
            for a in range(3):
                out[m, k] += net.marker_weight[m, a] * x[net.marker_node[m, a], k]


@njit(cache=True, nogil=True)
def finish(
    x, x1, x2, v1, v2, hv, rate, dt, n, net, cloth, paths, turn, held_on, targets, curvature, moment, crease, offset,
    size_of, lost, now, markers, leads, goals, goals_v,
):  # fmt: skip
    """End a step: bring straying twins nearer, carry memories over, shift the history, read the markers."""
    keep_near(x, x1, x2, hv, v1, v2, cloth, paths, curvature, moment, crease, offset, goals, goals_v, size_of, lost)
    for p in range(len(x)):
        targets_at(paths[p, n], net, turn, offset[p], targets[p])
        slip(x[p], net, cloth.scalar[p], targets[p], held_on, turn, offset[p], dt)
        remember(x[p], net, cloth.scalar[p], curvature[p], moment[p], crease[p], now)
        x2[p] = x1[p]
        x1[p] = x[p]
        v2[p] = v1[p]
        v1[p] = rate * x[p] + hv[p]
        _markers(x[p], net, markers[p, n])
        if lost[p]:
            markers[p, n] = markers[0, n]
            if len(leads):
                leads[p - 1, n] = 0.0
        elif p > 0:
            markers[p, n] = markers[0, n] + size_of[p] * (markers[p, n] - markers[0, n])
            if len(leads):
                leads[p - 1, n] = size_of[p] * (x[p] - x[0])


def march(
    x0, v0, dt, net, cloth, paths, turns, held_on, rounds, tolerance, goals, goals_v, guess, shapes, markers, forces, leads
):  # fmt: skip
    """Move every world along: `x0`, `v0` (P, V, 3); `paths` (P, T, H, 3); `turns` (T, G, 3, 3); `held_on` (T, H).

    Fills `shapes` (T, V, 3) of the base, `markers` (P, T, M, 3), `forces` (T, M, 3) of the pull to `goals` (P, T, M, 3), and `leads`
    (P - 1, T, V, 3) of the twins if there is room. Returns the step at which the base found no next state, or 0. `cloth`, `paths`
    and `goals` of twins are changed. `guess` (T, V, 3), or (0, V, 3): shapes of a similar simulation, from which Newton's method starts
    with what this one differs by.
    """
    count, size, stencils, steps = x0.shape[0], x0.shape[1], len(net.first) - 1, paths.shape[1]
    band = np.empty((3 * size, 3 * net_width(net) + 3))
    full, pivot = np.empty((3 * size, 3 * (band.shape[1] - 1) + 1)), np.empty(3 * size, np.int32)
    out = np.empty((size, 3))
    now = np.zeros((stencils, 3))
    curvature, moment, crease = (np.zeros((count, stencils, size)) for size in (3, 3, 6))
    offset = np.zeros((count, turns.shape[1], 3))
    targets = np.empty((count, len(net.held), 3))
    size_of, lost = np.ones(count), np.zeros(count, bool)
    x, x1, x2, v1, v2 = x0.copy(), x0.copy(), x0.copy(), v0.copy(), v0.copy()
    x3, guided = x0[0].copy(), len(guess) > 0
    right = np.empty((count - 1, size, 3))
    settle(x0, net, cloth, curvature, moment, crease)
    markers[:, 0] = (x0[:, net.marker_node] * net.marker_weight[..., None]).sum(2)
    shapes[0] = x0[0]
    if len(leads):
        leads[:, 0] = x0[1:] - x0[0]
    base, known = x[0], False
    for n in range(1, steps):
        if n == 1:  # an implicit Euler step starts the two-step formula
            rate, mass_rate = 1.0 / dt, 1.0 / (dt * dt)
            hv, ha = -x1 / dt, -x1 / (dt * dt) - v1 / dt
            base[:] = x1[0] - guess[0] + guess[1] if guided else x1[0] + dt * v1[0]
        else:
            rate, mass_rate = 1.5 / dt, 2.25 / (dt * dt)
            hv = (-4.0 * x1 + x2) / (2.0 * dt)
            ha = 1.5 / dt * hv + (-4.0 * v1 + v2) / (2.0 * dt)
            if guided:
                base[:] = 2.0 * (x1[0] - guess[n - 1]) - (x2[0] - guess[n - 2]) + guess[n]
            else:
                base[:] = 2.0 * x1[0] - x2[0] if n == 2 else 3.0 * x1[0] - 3.0 * x2[0] + x3
        targets_of(paths, n, net, turns[n], offset, targets)
        for softer, patience, anew in TRIES:
            if anew:
                base[:] = x1[0]
            last = newton(
                base, hv[0], ha[0], rate, mass_rate, softer * SLIDING_M_S, net, cloth, curvature[0], moment[0], crease[0],
                targets[0], held_on[n], tolerance, patience, goals[0, n], goals_v[0, n], known, band, out, forces[n],
            )  # fmt: skip
            if last >= 0.0 and softer == 1.0:
                break
            known = False
            if last < 0.0 and softer > 1.0:
                break
        if last < 0.0:
            return n
        known = n > 1  # the matrix changes little from step to step, but for the first, which is of another formula
        if count > 1:
            goal, goal_v = (
                np.ascontiguousarray(goals[:, n]),
                np.ascontiguousarray(goals_v[:, n]),
            )  # as at rest: compiled once
            kind = matrix(
                base, hv[0], rate, mass_rate, SLIDING_M_S, net, cloth, curvature[0], moment[0], held_on[n],
                goals[0, n], band, full, pivot,
            )  # fmt: skip
            if kind < 0:
                return n
            known = known and kind == 0
            x[1:] = base + 2.0 * (x1[1:] - x1[0]) - (x2[1:] - x2[0])  # the twins' lead grows as it did
            for _ in range(rounds):
                answers(
                    x, hv, ha, rate, mass_rate, SLIDING_M_S, net, cloth, curvature, moment, crease, targets, held_on[n],
                    goal, goal_v, right,
                )  # fmt: skip
                solved(kind, band, full, pivot, net, cloth, held_on[n], right)
                x[1:] -= right
        x3[:] = x2[0]
        finish(
            x, x1, x2, v1, v2, hv, rate, dt, n, net, cloth, paths, turns[n], held_on[n], targets,
            curvature, moment, crease, offset, size_of, lost, now, markers, leads, goals, goals_v,
        )  # fmt: skip
        shapes[n] = base
    return 0
