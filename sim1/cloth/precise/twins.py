"""Twins: how slightly different worlds answer, by the base's factor, and how they are kept close to it.

A twin is the same sheet in a slightly different world. As it stays close to the base, one factorization serves both, and a whole
Jacobian over dozens of parameters costs a few simulations instead of dozens: tangent-linear sensitivities without their formulas.
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import (
    ADHESION,
    AIR_NORMAL,
    AIR_SKIN,
    ALL_FACES,
    CLING,
    COMPLIANCE,
    DEFINITE,
    HYSTERESIS,
    PULL_STIFFNESS,
    RETAINED,
    SLIP_RATE,
    SLIP_THRESHOLD,
    STICTION,
    STRIBECK,
    TURN_CURVATURE,
    WIND_X,
    WIND_Z,
    YIELD,
)
from sim1.cloth.precise.forces import residual
from sim1.cloth.precise.jaws import coupling, solve_coupled
from sim1.cloth.precise.lapack import factor, factor_any
from sim1.cloth.precise.newton import largest
from sim1.cloth.precise.pull_forces import pull, pull_slope
from sim1.cloth.precise.smooth_push import push_nearer, smooth_push, smooth_push_slope
from sim1.cloth.precise.stiffness import derivative

FARTHEST_M = 1e-6  # a twin that strays further is brought nearer, with all that makes it differ: it stays linear
LOST = 1e3  # a lead that has grown so much tells nothing: the sheet is chaotic there, and the twin counts as the base


@njit(cache=True, nogil=True)
def matrix(x, hv, rate, mass_rate, sliding, net, cloth, curvature, moment, held_on, goal, band, full, pivot):
    """Factorize the matrix, compressed faces included, at the base's shape. 0: into `band`; 1: not definite, into `full`; -1: singular."""
    v = rate * x + hv
    for attempt in range(2):
        derivative(x, v, mass_rate, rate, sliding, net, cloth, curvature, moment, held_on, ALL_FACES, band)
        if cloth.scalar[0, PULL_STIFFNESS] > 0.0:
            pull_slope(net, cloth.scalar[0], goal, rate, band)
        smooth_push_slope(cloth.push, rate, band)
        if attempt == 0 and factor(band) == 0:
            return DEFINITE
    return DEFINITE + 1 if factor_any(band, full, pivot) == 0 else DEFINITE - 1


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
            pull(x[p], v, net, cloth.scalar[p], goal[p], goal_v[p], force, own)
        smooth_push(v, cloth.push, p, own)
        if p > 0:
            own -= left


def solved(kind, band, full, pivot, net, cloth, held_on, right):
    """Solve in place for `right` (k, V, 3) with what `matrix` has left; `kind` is what it said."""
    rows = coupling(net, held_on, cloth.scalar[0, COMPLIANCE], right[0].size)
    solve_coupled(kind, band, full, pivot, rows, right.reshape(len(right), -1))


@njit(cache=True, nogil=True)
def keep_near(x, x1, x2, hv, v1, v2, cloth, paths, curvature, moment, crease, offset, goals, goals_v, size_of, lost):
    """Bring twins that stray nearer to the base: state, history, memory and world.

    `size_of` (P,) grows by as much as a twin's lead was shrunk. A twin that is `lost` (P,) becomes the base.
    """
    for p in range(1, len(x)):
        lead = largest((x[p] - x[0]).ravel())
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
            # Where the base has no friction, what rubs is scaled and not how it turned so far.
            rubs = lost[p] or cloth.scalar[0, HYSTERESIS] != 0.0
            if rubs:
                _nearer(moment, p, shrink)
            if rubs or cloth.scalar[0, RETAINED] != 0.0:
                _nearer(curvature, p, shrink)
            _nearer(crease, p, shrink)
            _nearer(offset, p, shrink)
            _nearer_world(cloth, p, shrink)
            paths[p] = paths[0] + shrink * (paths[p] - paths[0])
            goals[p] = goals[0] + shrink * (goals[p] - goals[0])
            goals_v[p] = goals_v[0] + shrink * (goals_v[p] - goals_v[0])


@njit(cache=True, nogil=True)
def _nearer(group, p, shrink):
    """Bring a twin's state nearer to the base's."""
    if shrink == 0.0:
        group[p] = group[0]  # also where it was not finite any more
    else:
        group[p] = group[0] + shrink * (group[p] - group[0])


@njit(cache=True, nogil=True)
def _nearer_world(cloth, p, shrink):
    """Make a twin's world differ less from the base's.

    A number that says where, from when or which way an effect acts, of which the base lacks the strength, stays: there it is the strength
    that is scaled.
    """
    base = cloth.scalar[0]
    still_air = base[AIR_NORMAL] == 0.0 and base[AIR_SKIN] == 0.0
    for k in range(len(base)):
        absent = (
            (k == YIELD and base[RETAINED] == 0.0)
            or (k == SLIP_THRESHOLD and base[SLIP_RATE] == 0.0)
            or (k == TURN_CURVATURE and base[HYSTERESIS] == 0.0)
            or (k == CLING and base[ADHESION] == 0.0)
            or (k == STRIBECK and base[STICTION] == 1.0)
            or (WIND_X <= k <= WIND_Z and still_air)
        )
        if not absent:
            cloth.scalar[p, k] = base[k] + shrink * (cloth.scalar[p, k] - base[k])
    cloth.gradient[p] = cloth.gradient[0] + shrink * (cloth.gradient[p] - cloth.gradient[0])
    cloth.area[p] = cloth.area[0] + shrink * (cloth.area[p] - cloth.area[0])
    cloth.law[p] = cloth.law[0] + shrink * (cloth.law[p] - cloth.law[0])
    cloth.mass[p] = cloth.mass[0] + shrink * (cloth.mass[p] - cloth.mass[0])
    cloth.vertex_area[p] = cloth.vertex_area[0] + shrink * (cloth.vertex_area[p] - cloth.vertex_area[0])
    cloth.bend[p] = cloth.bend[0] + shrink * (cloth.bend[p] - cloth.bend[0])
    cloth.ripple[p] = cloth.ripple[0] + shrink * (cloth.ripple[p] - cloth.ripple[0])
    cloth.inertia[p] = cloth.inertia[0] + shrink * (cloth.inertia[p] - cloth.inertia[0])
    cloth.curl[p] = cloth.curl[0] + shrink * (cloth.curl[p] - cloth.curl[0])
    cloth.bend_area[p] = cloth.bend_area[0] + shrink * (cloth.bend_area[p] - cloth.bend_area[0])
    push_nearer(cloth.push, p, shrink)
