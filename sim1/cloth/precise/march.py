"""Time loops: BDF2 with Newton's method for the base, and twins that share its factor.

A twin is the same sheet in a slightly different world. As it stays close to the base, one factorization serves both, and a whole
Jacobian over dozens of parameters costs a few simulations instead of dozens: tangent-linear sensitivities without their formulas.
BDF2 is second order and does not damp slow swings: at 1 Hz and h = 1/60 s it loses 0.1 % a period, implicit Euler a third.
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import (
    COMPLIANCE,
    HYSTERESIS,
    PULL_DAMPING,
    PULL_STIFFNESS,
    RETAINED,
    SLIP_RATE,
    SLIP_THRESHOLD,
    TABLE_Z,
    YIELD,
)
from sim1.cloth.precise.forces import DAHL_1_M, FLAGS, GRIP_M_N, derivative, residual
from sim1.cloth.precise.lapack import factor, factor_any, solve, solve_any

SLIDING_M_S = 1e-3  # friction is regularised below this speed
RESTING_M = 5e-5  # while rest is sought, friction is regularised below this displacement in a step: what lies stays where it lies
FARTHEST_M = (
    1e-6  # a twin that strays further is brought nearer, with all that makes it differ, so that it stays linear
)
LOST = 1e3  # a lead that has grown so much tells nothing any more: the sheet is chaotic there, and the twin counts as the base
LONGEST_M = 0.1  # a Newton step moves no vertex further


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _curvatures(x, net, out):
    """Normal curvatures (C, 3) of the stencils, 1/m."""
    for c in range(len(net.first) - 1):
        u, v = np.zeros(3), np.zeros(3)
        k = np.zeros((3, 3))
        for a in range(net.first[c], net.first[c + 1]):
            for d in range(3):
                value = x[net.node[a], d]
                u[d] += net.slope[a, 0] * value
                v[d] += net.slope[a, 1] * value
                for e in range(3):
                    k[e, d] += net.second[a, e] * value
        n0, n1, n2 = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
        size = max(np.sqrt(n0 * n0 + n1 * n1 + n2 * n2), 1e-12)
        for e in range(3):
            out[c, e] = (k[e, 0] * n0 + k[e, 1] * n1 + k[e, 2] * n2) / size


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _remember(x, net, scalar, curvature, moment, crease, now):
    """Carry the memory of bending over a step: friction moment, and what folds keep."""
    if scalar[HYSTERESIS] == 0.0 and scalar[RETAINED] == 0.0:
        return
    _curvatures(x, net, now)
    for c in range(now.shape[0]):
        for k in range(3):
            change = now[c, k] - curvature[c, k]
            moment[c, k] = (moment[c, k] + change) / (1.0 + abs(change) / DAHL_1_M)
            curvature[c, k] = now[c, k]
            beyond = abs(now[c, k]) - scalar[YIELD]
            if beyond > 0.0 and scalar[RETAINED] * beyond > abs(crease[c, k]):
                crease[c, k] = scalar[RETAINED] * beyond * (1.0 if now[c, k] > 0.0 else -1.0)


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _slip(x, net, scalar, target, held_on, turn, offset, dt):
    """Let the cloth creep in its grips: `offset` (G, 3) in the frames of the drives."""
    if scalar[SLIP_RATE] == 0.0:
        return
    stiffness = 1.0 / (GRIP_M_N + scalar[COMPLIANCE])
    load = np.zeros(offset.shape)
    for h in range(len(net.held)):
        if held_on[h]:
            for k in range(3):
                load[net.grip[h], k] += stiffness * (x[net.held[h], k] - target[h, k])
    for g in range(len(offset)):
        size = np.sqrt(load[g, 0] ** 2 + load[g, 1] ** 2 + load[g, 2] ** 2)
        over = size - scalar[SLIP_THRESHOLD]
        if over > 0.0:
            step = dt * scalar[SLIP_RATE] * over / size
            for k in range(3):
                for d in range(3):
                    offset[g, k] += step * turn[g, d, k] * load[g, d]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _targets(path, net, turn, offset, out):
    """Where grips want their vertices (H, 3), what has slipped included."""
    for h in range(len(net.held)):
        g = net.grip[h]
        for k in range(3):
            out[h, k] = path[h, k]
            for d in range(3):
                out[h, k] += turn[g, k, d] * offset[g, d]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _markers(x, net, out):
    for m in range(len(net.marker_node)):
        for k in range(3):
            out[m, k] = 0.0
            for a in range(3):
                out[m, k] += net.marker_weight[m, a] * x[net.marker_node[m, a], k]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _pull(x, v, net, scalar, goal, goal_v, force, out):
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
def _pull_slope(net, scalar, goal, rate, band):
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


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _largest(change):
    most = 0.0
    for value in change:
        size = abs(value)
        if size > most:
            most = size
        elif not size <= most:
            return np.nan
    return most


@njit(cache=True, nogil=True)
def newton(
    x, hv, ha, rate, mass_rate, sliding, net, cloth, curvature, moment, crease, target, held_on,
    tolerance, most, goal, goal_v, band, out, force,
):  # fmt: skip
    """Solve a step of the base in place, with a line search that asks forces alone. Returns the last change [m].

    Negative: not converged, by so much; -inf: no matrix could be factorized or nothing is finite any more. `out` (V, 3) is
    left with the residual, `force` (M, 3) with the pull on the markers.
    """
    change = np.zeros_like(x)
    v, acc = np.empty_like(x), np.empty_like(x)
    last, size, share, first = 1e30, 1e30, 1.0, 0.0
    old, fresh = True, True
    trial = searches = 0
    while True:
        x -= share * change
        v[:] = rate * x + hv
        acc[:] = mass_rate * x + ha
        residual(x, v, acc, sliding, net, cloth, 0, curvature, moment, crease, target, held_on, out)
        if cloth.scalar[0, PULL_STIFFNESS] > 0.0:
            _pull(x, v, net, cloth.scalar[0], goal, goal_v, force, out)
        if not fresh:
            slope = _dot(out, change)
            if slope < -0.6 * first and size * share > 10.0 * tolerance and searches < 5:
                x += share * change  # the valley lies well behind: back to where the secant puts it
                share *= min(max(first / (first - slope), 0.1), 0.7)
                searches += 1
                continue
            if size < tolerance:
                return size
            old = share < 0.99 or (trial > 1 and size > 0.25 * last) or trial > 10
            last = 1e30 if old else size
            if trial >= most:
                return -size
        if old:
            for careful in range(2):
                tension_only = careful == 1 or trial > most // 2
                derivative(
                    x, v, mass_rate, rate, sliding, net, cloth, curvature, moment, held_on, tension_only, band
                )  # fmt: skip
                if cloth.scalar[0, PULL_STIFFNESS] > 0.0:
                    _pull_slope(net, cloth.scalar[0], goal, rate, band)
                failed = factor(band)
                if failed == 0:
                    break
            if failed != 0:
                return -np.inf
            old = False
        change[:] = out
        solve(band, change.reshape(1, -1))
        size = _largest(change.ravel())
        if not size < 1e3:
            return -np.inf
        share = min(1.0, LONGEST_M / max(size, 1e-12))
        first = _dot(out, change)
        fresh, searches = False, 0
        trial += 1


@njit(cache=True, nogil=True)
def answers(
    x, hv, ha, rate, mass_rate, sliding, net, cloth, curvature, moment, crease, targets, held_on, goal, goal_v, right
):  # fmt: skip
    """Residuals (P - 1, V, 3) of the twins less what the base leaves unsolved, into `right`."""
    v, acc, left = np.empty_like(x[0]), np.empty_like(x[0]), np.empty_like(x[0])
    force = np.empty((len(net.marker_node), 3))
    for p in range(x.shape[0]):
        v[:] = rate * x[p] + hv[p]
        acc[:] = mass_rate * x[p] + ha[p]
        own = left if p == 0 else right[p - 1]
        residual(x[p], v, acc, sliding, net, cloth, p, curvature[p], moment[p], crease[p], targets[p], held_on, own)
        if cloth.scalar[0, PULL_STIFFNESS] > 0.0:
            _pull(x[p], v, net, cloth.scalar[p], goal[p], goal_v[p], force, own)
        if p > 0:
            own -= left


@njit(cache=True, nogil=True)
def matrix(x, hv, rate, mass_rate, sliding, net, cloth, curvature, moment, held_on, goal, band, full, pivot):
    """Factorize the exact matrix at the base's shape. 0: into `band`; 1: not definite, into `full`; -1: singular."""
    v = rate * x + hv
    derivative(x, v, mass_rate, rate, sliding, net, cloth, curvature, moment, held_on, False, band)
    if cloth.scalar[0, PULL_STIFFNESS] > 0.0:
        _pull_slope(net, cloth.scalar[0], goal, rate, band)
    plain = band.copy()
    if factor(band) == 0:
        return 0
    return 1 if factor_any(plain, full, pivot) == 0 else -1


@njit(cache=True, nogil=True)
def targets_of(paths, n, net, turn, offset, out):
    """Where the grips of every world want their vertices at step `n`, (P, H, 3)."""
    for p in range(len(out)):
        _targets(paths[p, n], net, turn, offset[p], out[p])


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


@njit(cache=True, nogil=True)
def _nearer(group, p, shrink):
    """Bring a twin's state nearer to the base's."""
    if shrink == 0.0:
        group[p] = group[0]  # also where it was not finite any more
    else:
        group[p] = group[0] + shrink * (group[p] - group[0])


@njit(cache=True, nogil=True)
def _nearer_world(cloth, p, shrink):
    """Make a twin's world differ less from the base's; thresholds stay, as what they start is scaled."""
    for k in range(cloth.scalar.shape[1]):
        if k not in (YIELD, SLIP_THRESHOLD):
            cloth.scalar[p, k] = cloth.scalar[0, k] + shrink * (cloth.scalar[p, k] - cloth.scalar[0, k])
    cloth.gradient[p] = cloth.gradient[0] + shrink * (cloth.gradient[p] - cloth.gradient[0])
    cloth.area[p] = cloth.area[0] + shrink * (cloth.area[p] - cloth.area[0])
    cloth.law[p] = cloth.law[0] + shrink * (cloth.law[p] - cloth.law[0])
    cloth.mass[p] = cloth.mass[0] + shrink * (cloth.mass[p] - cloth.mass[0])
    cloth.vertex_area[p] = cloth.vertex_area[0] + shrink * (cloth.vertex_area[p] - cloth.vertex_area[0])
    cloth.bend[p] = cloth.bend[0] + shrink * (cloth.bend[p] - cloth.bend[0])
    cloth.curl[p] = cloth.curl[0] + shrink * (cloth.curl[p] - cloth.curl[0])
    cloth.bend_area[p] = cloth.bend_area[0] + shrink * (cloth.bend_area[p] - cloth.bend_area[0])


@njit(cache=True, nogil=True)
def settle(x, net, cloth, curvature, moment, crease):
    """Curvature at the start, and what folds that are there have kept, of every world."""
    for p in range(len(x)):
        _curvatures(x[p], net, curvature[p])
        for c in range(curvature.shape[1]):
            for k in range(3):
                beyond = abs(curvature[p, c, k]) - cloth.scalar[p, YIELD]
                if beyond > 0.0:
                    crease[p, c, k] = cloth.scalar[p, RETAINED] * beyond * (1.0 if curvature[p, c, k] > 0.0 else -1.0)


@njit(cache=True, nogil=True)
def finish(
    x, x1, x2, v1, v2, hv, rate, dt, n, net, cloth, paths, turn, held_on, targets, curvature, moment, crease, offset,
    size_of, lost, now, markers, leads, goals, goals_v,
):  # fmt: skip
    """End a step: bring straying twins nearer, carry memories over, shift the history, read the markers."""
    base = x[0]
    for p in range(1, len(x)):
        lead = _largest((x[p] - base).ravel())
        if not lead < FARTHEST_M and not lost[p]:
            if not lead < 1.0 or size_of[p] > LOST:
                lost[p] = True
            shrink = 0.0 if lost[p] else 0.1 * FARTHEST_M / lead
            size_of[p] *= lead / (0.1 * FARTHEST_M)
            _nearer(x, p, shrink)
            _nearer(x1, p, shrink)
            _nearer(x2, p, shrink)
            _nearer(hv, p, shrink)  # with it the velocity that is about to be read off
            _nearer(v1, p, shrink)
            _nearer(v2, p, shrink)
            _nearer(curvature, p, shrink)
            _nearer(moment, p, shrink)
            _nearer(crease, p, shrink)
            _nearer(offset, p, shrink)
            _nearer_world(cloth, p, shrink)
            paths[p] = paths[0] + shrink * (paths[p] - paths[0])
            goals[p] = goals[0] + shrink * (goals[p] - goals[0])
            goals_v[p] = goals_v[0] + shrink * (goals_v[p] - goals_v[0])
    for p in range(len(x)):
        _targets(paths[p, n], net, turn, offset[p], targets[p])
        _slip(x[p], net, cloth.scalar[p], targets[p], held_on, turn, offset[p], dt)
        _remember(x[p], net, cloth.scalar[p], curvature[p], moment[p], crease[p], now)
        x2[p] = x1[p]
        x1[p] = x[p]
        v2[p] = v1[p]
        v1[p] = rate * x[p] + hv[p]
        _markers(x[p], net, markers[p, n])
        if lost[p]:
            markers[p, n] = markers[0, n]
        elif p > 0:
            markers[p, n] = markers[0, n] + size_of[p] * (markers[p, n] - markers[0, n])
            if len(leads):
                leads[p - 1, n] = size_of[p] * (x[p] - base)


def rest(x, net, cloth, paths, turn, held_on, tolerance, goals, *, rounds=8, most=600):
    """Bring every world to rest, in place: `x` (P, V, 3), pulled to `goals` (P, M, 3). Returns whether the base came to rest.

    Implicit Euler with a growing step and no velocity carried along: energy only falls. Twins follow with the base's factor.
    """
    count, size, stencils = x.shape[0], x.shape[1], len(net.first) - 1
    band = np.empty((3 * size, 3 * net_width(net) + 3))
    out, force, nothing = np.empty((size, 3)), np.empty((len(net.marker_node), 3)), np.zeros((stencils, 3))
    goal, still = goals[0], np.zeros(goals.shape)
    h, done, base = 0.004, False, x[0]
    rubs = not np.isnan(cloth.scalar[0, TABLE_Z])
    for _ in range(most):
        before = base.copy()
        last = newton(
            base, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
            nothing, nothing, nothing, paths[0], held_on, 1e-7, 8, goal, still[0], band, out, force,
        )  # fmt: skip
        if last == -np.inf:
            base[:] = before
            h *= 0.25
            if h < 1e-6:
                return False
            continue
        moved = np.abs(base - before).max()
        creeps = rubs and h > 0.9 and moved < 1.5 * RESTING_M  # all that is left is what regularised friction lets pass
        if creeps or (-last < 1e-7 and moved < max(tolerance * h * h, 2e-7) and moved < 1e-5 and h > 0.05):
            done = True
            break
        # An inexact step still goes down; a very inexact one says that the next had better be shorter.
        h = min(h * 1.5, 1.0) if -last < 0.05 * moved else max(h * 0.6, 1e-4)
    if not done:
        return False
    if count > 1:
        h = 1.0
        for _ in range(3):  # twins are told from the base: what it still lacks to rest would count as their answer
            before = base.copy()
            newton(
                base, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
                nothing, nothing, nothing, paths[0], held_on, 1e-11, 20, goal, still[0], band, out, force,
            )  # fmt: skip
        full, pivot = np.empty((3 * size, 3 * (band.shape[1] - 1) + 1)), np.empty(3 * size, np.int32)
        kind = matrix(
            base,
            -base / h,
            1.0 / h,
            1.0 / (h * h),
            RESTING_M / h,
            net,
            cloth,
            nothing,
            nothing,
            held_on,
            goal,
            band,
            full,
            pivot,
        )
        if kind < 0:
            return False
        x[1:] = base
        right, nothings = np.empty((count - 1, size, 3)), np.zeros((count, stencils, 3))
        before = x.copy()
        for number in range(rounds):
            answers(
                x, -before / h, -before / (h * h), 1.0 / h, 1.0 / (h * h), RESTING_M / h, net, cloth,
                nothings, nothings, nothings, paths, held_on, goals, still, right,
            )  # fmt: skip
            _solved(kind, band, full, pivot, right)
            x[1:] -= right
            if number % 2:
                before[1:] = x[1:]
        astray = ~(np.abs(x - base).max((1, 2)) < FARTHEST_M * 50)  # it rests elsewhere: tells nothing of the start
        x[astray] = base
    return True


def _solved(kind, band, full, pivot, right):
    if kind == 0:
        solve(band, right.reshape(len(right), -1))
    else:
        solve_any(full, pivot, right.reshape(len(right), -1))


def march(
    x0,
    v0,
    dt,
    net,
    cloth,
    paths,
    turns,
    held_on,
    rounds,
    tolerance,
    goals,
    goals_v,
    guess,
    shapes,
    markers,
    forces,
    leads,
):
    """Move every world along: `x0`, `v0` (P, V, 3); `paths` (P, T, H, 3); `turns` (T, G, 3, 3); `held_on` (T, H).

    Fills `shapes` (T, V, 3) of the base, `markers` (P, T, M, 3) `forces` (T, M, 3) of the pull to `goals` (P, T, M, 3), and `leads` (P - 1, T, V, 3) of the twins if there is room. Returns the step at which
    the base found no next state, or 0. `cloth`, `paths` and `goals` of twins are changed. `guess` (T, V, 3), or (0, V, 3): shapes of a
    similar simulation, from which Newton's method starts with what this one differs by.
    """
    count, size, stencils, steps = x0.shape[0], x0.shape[1], len(net.first) - 1, paths.shape[1]
    band = np.empty((3 * size, 3 * net_width(net) + 3))
    full, pivot = np.empty((3 * size, 3 * (band.shape[1] - 1) + 1)), np.empty(3 * size, np.int32)
    out = np.empty((size, 3))
    now = np.zeros((stencils, 3))
    curvature, moment, crease = (np.zeros((count, stencils, 3)) for _ in range(3))
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
    base = x[0]
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
        for patience in (40, 120):
            last = newton(
                base, hv[0], ha[0], rate, mass_rate, SLIDING_M_S, net, cloth, curvature[0], moment[0], crease[0],
                targets[0], held_on[n], tolerance, patience, goals[0, n], goals_v[0, n], band, out, forces[n],
            )  # fmt: skip
            if last >= 0.0:
                break
            base[:] = x1[0]  # from the last shape, with patience
        if last < 0.0:
            return n
        if count > 1:
            kind = matrix(
                base, hv[0], rate, mass_rate, SLIDING_M_S, net, cloth, curvature[0], moment[0], held_on[n],
                goals[0, n], band, full, pivot,
            )  # fmt: skip
            if kind < 0:
                return n
            x[1:] = base + 2.0 * (x1[1:] - x1[0]) - (x2[1:] - x2[0])  # the twins' lead grows as it did
            for _ in range(rounds):
                answers(
                    x, hv, ha, rate, mass_rate, SLIDING_M_S, net, cloth, curvature, moment, crease, targets, held_on[n],
                    goals[:, n], goals_v[:, n], right,
                )  # fmt: skip
                _solved(kind, band, full, pivot, right)
                x[1:] -= right
        x3[:] = x2[0]
        finish(
            x, x1, x2, v1, v2, hv, rate, dt, n, net, cloth, paths, turns[n], held_on[n], targets,
            curvature, moment, crease, offset, size_of, lost, now, markers, leads, goals, goals_v,
        )  # fmt: skip
        shapes[n] = base
    return 0
