"""Bending: the forces that stencils resist it with, and how these answer to the shape.

Second derivatives of the shape over the material are fitted around every inner vertex; the energy is quadratic in them, as cloth bends almost
without stretching (Bergou et al. 2006). Damping, friction, folds and curvature at rest act along the normal alone.
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import DAMPING, HYSTERESIS, TURN_CURVATURE
from sim1.cloth.precise.compiled_code import FLAGS


@njit(cache=True, nogil=True, fastmath=FLAGS)
def normal_of(x, net, c):
    """Unit normal of the sheet in the middle of stencil `c`."""
    ux = uy = uz = vx = vy = vz = 0.0
    for a in range(net.first[c], net.first[c + 1]):
        i = net.node[a]
        ux += net.slope[a, 0] * x[i, 0]
        uy += net.slope[a, 0] * x[i, 1]
        uz += net.slope[a, 0] * x[i, 2]
        vx += net.slope[a, 1] * x[i, 0]
        vy += net.slope[a, 1] * x[i, 1]
        vz += net.slope[a, 1] * x[i, 2]
    return across(ux, uy, uz, vx, vy, vz)


@njit(cache=True, nogil=True, fastmath=FLAGS)
def across(ux, uy, uz, vx, vy, vz):
    """Unit normal of two directions u and v."""
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    size = 1.0 / max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
    return nx * size, ny * size, nz * size


@njit(cache=True, nogil=True)
def turned_by(moment, change, turn):
    """Dahl's z times the slip curvature `turn`, after the curvature changed one way by `change` [all 1/m]: exact, in however many steps."""
    way = turn if change >= 0.0 else -turn
    return moment + (moment - way) * np.expm1(-abs(change) / turn)


@njit(cache=True, nogil=True, fastmath=FLAGS)
def resist_bending(x, v, net, cloth, p, curvature, moment, crease, out):
    """Add to the residual `out` (V, 3) of world `p` what stencils resist bending with; see `forces.residual`."""
    s = cloth.scalar[p]
    for c in range(len(net.first) - 1):
        begin, end = net.first[c], net.first[c + 1]
        ux = uy = uz = vx = vy = vz = 0.0  # first derivatives of the shape, then second ones: uu, vv, uv
        aux = auy = auz = avx = avy = avz = atx = aty = atz = 0.0
        bux = buy = buz = bvx = bvy = bvz = btx = bty = btz = 0.0  # and how fast these change
        for a in range(begin, end):
            i = net.node[a]
            px, py, pz, qx, qy, qz = x[i, 0], x[i, 1], x[i, 2], v[i, 0], v[i, 1], v[i, 2]
            su, sv = net.slope[a, 0], net.slope[a, 1]
            wu, wv, wt = net.second[a, 0], net.second[a, 1], net.second[a, 2]
            ux, uy, uz = ux + su * px, uy + su * py, uz + su * pz
            vx, vy, vz = vx + sv * px, vy + sv * py, vz + sv * pz
            aux, auy, auz = aux + wu * px, auy + wu * py, auz + wu * pz
            avx, avy, avz = avx + wv * px, avy + wv * py, avz + wv * pz
            atx, aty, atz = atx + wt * px, aty + wt * py, atz + wt * pz
            bux, buy, buz = bux + wu * qx, buy + wu * qy, buz + wu * qz
            bvx, bvy, bvz = bvx + wv * qx, bvy + wv * qy, bvz + wv * qz
            btx, bty, btz = btx + wt * qx, bty + wt * qy, btz + wt * qz
        nx, ny, nz = across(ux, uy, uz, vx, vy, vz)
        # Only the normal part of the rates is damped: a bent sheet that turns as a whole keeps its energy.
        bend = cloth.bend[p, c]
        extra_u = s[DAMPING] * (bux * nx + buy * ny + buz * nz) - cloth.curl[p, c, 0] - crease[c, 0]
        extra_v = s[DAMPING] * (bvx * nx + bvy * ny + bvz * nz) - cloth.curl[p, c, 1] - crease[c, 1]
        extra_t = s[DAMPING] * (btx * nx + bty * ny + btz * nz) - cloth.curl[p, c, 2] - crease[c, 2]
        extra_u, extra_v, extra_t = bend[0] * extra_u, bend[1] * extra_v, bend[2] * extra_t
        if s[HYSTERESIS] != 0.0:
            per, slip = s[HYSTERESIS] * cloth.bend_area[p, c] / s[TURN_CURVATURE], s[TURN_CURVATURE]
            if bend[0] != 0.0:
                extra_u += per * turned_by(moment[c, 0], aux * nx + auy * ny + auz * nz - curvature[c, 0], slip)
            if bend[1] != 0.0:
                extra_v += per * turned_by(moment[c, 1], avx * nx + avy * ny + avz * nz - curvature[c, 1], slip)
            if bend[2] != 0.0:
                extra_t += 2.0 * per * turned_by(moment[c, 2], atx * nx + aty * ny + atz * nz - curvature[c, 2], slip)
        aux, auy, auz = bend[0] * aux + extra_u * nx, bend[0] * auy + extra_u * ny, bend[0] * auz + extra_u * nz
        avx, avy, avz = bend[1] * avx + extra_v * nx, bend[1] * avy + extra_v * ny, bend[1] * avz + extra_v * nz
        atx, aty, atz = bend[2] * atx + extra_t * nx, bend[2] * aty + extra_t * ny, bend[2] * atz + extra_t * nz
        for a in range(begin, end):
            i = net.node[a]
            wu, wv, wt = net.second[a, 0], net.second[a, 1], net.second[a, 2]
            out[i, 0] += wu * aux + wv * avx + wt * atx
            out[i, 1] += wu * auy + wv * avy + wt * aty
            out[i, 2] += wu * auz + wv * avz + wt * atz
        firm = cloth.ripple[p, c]
        for e in range(min(end - begin - 6, net.ripple.shape[1])):  # what no quadratic follows would be free to flutter
            rx = ry = rz = 0.0
            for a in range(begin, end):
                i = net.node[a]
                w = net.ripple[a, e]
                rx += w * x[i, 0]
                ry += w * x[i, 1]
                rz += w * x[i, 2]
            rx, ry, rz = firm * rx, firm * ry, firm * rz
            for a in range(begin, end):
                i = net.node[a]
                w = net.ripple[a, e]
                out[i, 0] += w * rx
                out[i, 1] += w * ry
                out[i, 2] += w * rz


@njit(cache=True, nogil=True, fastmath=FLAGS)
def add_bending(x, net, cloth, rate, curvature, moment, blocks):
    """Add to `blocks` (B, 9) what stencils resist with: alike along every axis, and along the normal alone where it is damping or friction."""
    s = cloth.scalar[0]
    damping, pair = s[DAMPING] * rate, 0
    for c in range(len(net.first) - 1):
        begin, end = net.first[c], net.first[c + 1]
        uu, vv, uv = cloth.bend[0, c, 0], cloth.bend[0, c, 1], cloth.bend[0, c, 2]
        firm, ripples = cloth.ripple[0, c], min(end - begin - 6, net.ripple.shape[1])
        nx, ny, nz = normal_of(x, net, c)
        rub_uu = rub_vv = rub_uv = 0.0
        if s[HYSTERESIS] != 0.0:
            rub_uu, rub_vv, rub_uv = _friction(x, net, cloth, curvature, moment, c, nx, ny, nz)
        for a in range(begin, end):
            w0, w1, w2 = net.second[a, 0], net.second[a, 1], net.second[a, 2]
            for b in range(begin, a + 1):
                ww0, ww1, ww2 = w0 * net.second[b, 0], w1 * net.second[b, 1], w2 * net.second[b, 2]
                alike = uu * ww0 + vv * ww1 + uv * ww2
                along = damping * alike + rub_uu * ww0 + rub_vv * ww1 + rub_uv * ww2
                for e in range(ripples):
                    alike += firm * net.ripple[a, e] * net.ripple[b, e]
                ax, ay, az = along * nx, along * ny, along * nz
                block = blocks[net.stencil_pair[pair]]
                block[0] += alike + ax * nx
                block[1] += ax * ny
                block[2] += ax * nz
                block[3] += ax * ny
                block[4] += alike + ay * ny
                block[5] += ay * nz
                block[6] += ax * nz
                block[7] += ay * nz
                block[8] += alike + az * nz
                pair += 1


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _friction(x, net, cloth, curvature, moment, c, nx, ny, nz):
    """How the friction of bending in a stencil grows with its curvatures (uu, vv, uv), by the slope of the Dahl update."""
    turn = cloth.scalar[0, TURN_CURVATURE]
    uu = vv = uv = 0.0
    for a in range(net.first[c], net.first[c + 1]):
        i = net.node[a]
        high = x[i, 0] * nx + x[i, 1] * ny + x[i, 2] * nz
        uu += net.second[a, 0] * high
        vv += net.second[a, 1] * high
        uv += net.second[a, 2] * high
    per = cloth.scalar[0, HYSTERESIS] * cloth.bend_area[0, c] / turn
    return (
        per * _slope_of_turn(uu - curvature[c, 0], moment[c, 0], turn),
        per * _slope_of_turn(vv - curvature[c, 1], moment[c, 1], turn),
        2.0 * per * _slope_of_turn(uv - curvature[c, 2], moment[c, 2], turn),
    )


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _slope_of_turn(change, moment, turn):
    """Derivative of `turned_by` over the change."""
    sign = 1.0 if change >= 0.0 else -1.0
    return max((1.0 - sign * moment / turn) * np.exp(-abs(change) / turn), 0.0)
