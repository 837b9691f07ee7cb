"""What a sheet and its grips remember from step to step: friction of bending, folds, cloth that slipped."""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import COMPLIANCE, HYSTERESIS, RETAINED, SLIP_RATE, SLIP_THRESHOLD, TURN_CURVATURE, YIELD
from sim1.cloth.precise.bending import normal_of, turned_by
from sim1.cloth.precise.compiled_code import FLAGS
from sim1.cloth.precise.jaws import grip_loads


@njit(cache=True, nogil=True, fastmath=FLAGS)
def curvatures(x, net, out):
    """Normal curvatures (C, 3) of the stencils, 1/m."""
    for c in range(len(net.first) - 1):
        nx, ny, nz = normal_of(x, net, c)
        out[c] = 0.0
        for a in range(net.first[c], net.first[c + 1]):
            i = net.node[a]
            high = x[i, 0] * nx + x[i, 1] * ny + x[i, 2] * nz
            for e in range(3):
                out[c, e] += net.second[a, e] * high


@njit(cache=True, nogil=True)
def settle(x, net, cloth, curvature, moment, crease):
    """Curvature, friction moment and what folds have kept at the start, of every world: all bent from flat, once."""
    for p in range(len(x)):
        curvatures(x[p], net, curvature[p])
        crease[p] = 0.0
        fold(curvature[p], cloth.scalar[p], crease[p])
        for c in range(curvature.shape[1]):
            for k in range(3):
                moment[p, c, k] = turned_by(0.0, curvature[p, c, k], cloth.scalar[p, TURN_CURVATURE])


@njit(cache=True, nogil=True)
def fold(curvature, scalar, crease):
    """Let folds keep a share of what `curvature` (C, 3) is beyond yield; the rest of it raises the yield, whichever way it was bent.

    `crease` (C, 6): curvature that is kept, and all that ever was, backwards and forwards.
    """
    kept = scalar[RETAINED]
    if kept == 0.0:
        return
    for c in range(len(crease)):
        for k in range(3):
            elastic = curvature[c, k] - crease[c, k]
            beyond = abs(elastic) - scalar[YIELD] - (1.0 - kept) / kept * crease[c, 3 + k]
            if beyond > 0.0:
                crease[c, k] += kept * beyond * (1.0 if elastic > 0.0 else -1.0)
                crease[c, 3 + k] += kept * beyond


@njit(cache=True, nogil=True, fastmath=FLAGS)
def remember(x, net, scalar, curvature, moment, crease, now):
    """Carry the memory of bending over a step: friction moment, and what folds keep."""
    if scalar[HYSTERESIS] == 0.0 and scalar[RETAINED] == 0.0:
        return
    curvatures(x, net, now)
    for c in range(now.shape[0]):
        for k in range(3):
            change = now[c, k] - curvature[c, k]
            moment[c, k] = turned_by(moment[c, k], change, scalar[TURN_CURVATURE])
            curvature[c, k] = now[c, k]
    fold(now, scalar, crease)


@njit(cache=True, nogil=True, fastmath=FLAGS)
def slip(x, net, scalar, target, held_on, turn, offset, dt):
    """Let the cloth creep in its grips: `offset` (G, 3) in the frames of the drives."""
    if scalar[SLIP_RATE] == 0.0:
        return
    load = np.empty(offset.shape)
    grip_loads(x, net, target, held_on, scalar[COMPLIANCE], load)
    for g in range(len(offset)):
        size = np.sqrt(load[g, 0] ** 2 + load[g, 1] ** 2 + load[g, 2] ** 2)
        over = size - scalar[SLIP_THRESHOLD]
        if over > 0.0:
            step = dt * scalar[SLIP_RATE] * over / size
            for k in range(3):
                for d in range(3):
                    offset[g, k] += step * turn[g, d, k] * load[g, d]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def targets_at(path, net, turn, offset, out):
    """Where grips want their vertices (H, 3), what has slipped included."""
    for h in range(len(net.held)):
        g = net.grip[h]
        for k in range(3):
            out[h, k] = path[h, k]
            for d in range(3):
                out[h, k] += turn[g, k, d] * offset[g, d]


@njit(cache=True, nogil=True)
def targets_of(paths, n, net, turn, offset, out):
    """Where the grips of every world want their vertices at step `n`, (P, H, 3)."""
    for p in range(len(out)):
        targets_at(paths[p, n], net, turn, offset[p], out[p])
