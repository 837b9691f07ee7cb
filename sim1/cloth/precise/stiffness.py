"""How the forces on a sheet answer to its shape: the derivative of `residual`, a banded matrix.

Each force of `forces.py` has its part here. Left out is what is small or would make the matrix unsymmetric: that normals turn (air,
curl, folds), that friction turns with the sliding, that adhesion fades. Forces alone say where an iteration ends.
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import (
    ADDED_MASS,
    AIR_NORMAL,
    AIR_SKIN,
    DAMPING,
    FRICTION_X,
    FRICTION_Y,
    HYSTERESIS,
    STICTION,
    STIFFENING,
    STRIBECK,
    TABLE_Z,
    TURN_CURVATURE,
    WIND_X,
)
from sim1.cloth.precise.forces import (
    CONTACT_N_M3,
    FLAGS,
    OWN_SHARE,
    normal_of,
    stress_of,
    workspace_of,
)
from sim1.cloth.precise.jaws import GRIP_M_N


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _add_block(band, i, j, block):
    """Add `block` (3, 3) at vertices i, j, if it belongs to the lower triangle."""
    if i < j:
        return
    for a in range(3):
        for b in range(3):
            if i > j or a >= b:
                band[3 * j + b, 3 * (i - j) + a - b] += block[a, b]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _tangent(strain, law, s, rate, out):
    """Derivative (3, 3) of the stress over the strain, where strain rates grow with it at `rate`."""
    slow, twice = 1.0 + s[DAMPING] * rate, 2.0 * s[STIFFENING]
    out[:] = 0.0
    out[0, 0] = law[0] * (slow + twice * max(strain[0], 0.0))
    out[1, 1] = law[1] * (slow + twice * max(strain[1], 0.0))
    out[2, 2] = law[3] * slow
    out[0, 1] = out[1, 0] = law[2] * slow


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _add_friction(x, net, cloth, curvature, moment, c, block, band):
    """Add what the friction of bending in a stencil resists with, by the slope of the Dahl update."""
    begin, end = net.first[c], net.first[c + 1]
    nx, ny, nz = normal_of(x, net, c)
    turn = cloth.scalar[0, TURN_CURVATURE]
    for k in range(3):
        bent = 0.0
        for a in range(begin, end):
            i = net.node[a]
            bent += net.second[a, k] * (x[i, 0] * nx + x[i, 1] * ny + x[i, 2] * nz)
        change = abs(bent - curvature[c, k])
        sign = 1.0 if bent >= curvature[c, k] else -1.0  # the derivative of `turned_by`
        grow = (1.0 - sign * moment[c, k] / turn) * np.exp(-change / turn)
        twice = 2.0 if k == 2 else 1.0
        friction = max(grow, 0.0) * cloth.scalar[0, HYSTERESIS] * twice * cloth.bend_area[0, c] / turn
        for a in range(begin, end):
            i = net.node[a]
            for b in range(begin, end):
                j = net.node[b]
                if i < j:
                    continue
                ww = friction * net.second[a, k] * net.second[b, k]
                block[0, 0], block[1, 1], block[2, 2] = ww * nx * nx, ww * ny * ny, ww * nz * nz
                block[0, 1] = block[1, 0] = ww * nx * ny
                block[0, 2] = block[2, 0] = ww * nx * nz
                block[1, 2] = block[2, 1] = ww * ny * nz
                _add_block(band, i, j, block)


@njit(cache=True, nogil=True, fastmath=FLAGS)
def derivative(x, v, mass_rate, rate, sliding, net, cloth, curvature, moment, held_on, tension_only, band):
    """Derivative of `residual` of the base over x, where velocity = rate x + ..., acceleration = mass_rate x + ...; into `band`.

    What yielding jaws couple is left out: see `jaws.coupling`.

    With `tension_only` compressed faces keep no geometric part, which makes the matrix positive definite.
    """
    s = cloth.scalar[0]
    tau = s[DAMPING]
    band[:] = 0.0
    block = np.empty((3, 3))
    strain = np.empty((3, 3, 3))  # (corner, strain, axis)
    for i in range(len(x)):
        for k in range(3):
            band[3 * i + k, 0] += mass_rate * cloth.mass[0, i]
    airy = s[AIR_NORMAL] != 0.0 or s[AIR_SKIN] != 0.0
    added = s[ADDED_MASS]
    both = np.empty((3, 3))
    law = cloth.law[0]
    sides, mean, stress = workspace_of(x, net)
    for f in range(len(net.faces)):
        g = cloth.gradient[0, f]
        side = sides[f]
        side[:12] = 0.0
        for c in range(3):
            i = net.faces[f, c]
            for k in range(3):
                side[k] += g[c, 0] * x[i, k]
                side[3 + k] += g[c, 1] * x[i, k]
                side[6 + k] += g[c, 0] * v[i, k]
                side[9 + k] += g[c, 1] * v[i, k]
        side[12] = 0.5 * (side[0] * side[0] + side[1] * side[1] + side[2] * side[2] - 1.0)
        side[13] = 0.5 * (side[3] * side[3] + side[4] * side[4] + side[5] * side[5] - 1.0)
        side[14] = side[0] * side[3] + side[1] * side[4] + side[2] * side[5]
        side[15] = side[0] * side[6] + side[1] * side[7] + side[2] * side[8]
        side[16] = side[3] * side[9] + side[4] * side[10] + side[5] * side[11]
        side[17] = side[0] * side[9] + side[1] * side[10] + side[2] * side[11]
        side[17] += side[6] * side[3] + side[7] * side[4] + side[8] * side[5]
        for c in range(3):
            i = net.faces[f, c]
            share = cloth.area[0, f] / (3.0 * cloth.vertex_area[0, i])
            for k in range(6):
                mean[i, k] += share * side[12 + k]
    tangent = np.empty((3, 3))
    ring = np.empty((np.diff(net.ring_first).max(), 3, 3))  # (node, strain, axis), room for the most around a vertex
    for i in range(len(x)):
        stress_of(mean[i], law, s, stress[i])
        _tangent(mean[i], law, s, rate, tangent)
        begin, count = net.ring_first[i], net.ring_first[i + 1] - net.ring_first[i]
        ring[:count] = 0.0
        for e in range(net.star_first[i], net.star_first[i + 1]):
            f = net.star_face[e]
            share = cloth.area[0, f] / (3.0 * cloth.vertex_area[0, i])
            side, g = sides[f], cloth.gradient[0, f]
            for c in range(3):
                a = net.star_local[e, c]
                for k in range(3):
                    ring[a, 0, k] += share * g[c, 0] * side[k]
                    ring[a, 1, k] += share * g[c, 1] * side[3 + k]
                    ring[a, 2, k] += share * (g[c, 0] * side[3 + k] + g[c, 1] * side[k])
        weight = (1.0 - OWN_SHARE) * cloth.vertex_area[0, i]
        for a in range(count):
            ia = net.ring_node[begin + a]
            for k in range(3):
                left0 = tangent[0, 0] * ring[a, 0, k] + tangent[0, 1] * ring[a, 1, k] + tangent[0, 2] * ring[a, 2, k]
                left1 = tangent[1, 0] * ring[a, 0, k] + tangent[1, 1] * ring[a, 1, k] + tangent[1, 2] * ring[a, 2, k]
                left2 = tangent[2, 0] * ring[a, 0, k] + tangent[2, 1] * ring[a, 1, k] + tangent[2, 2] * ring[a, 2, k]
                strain[0, 0, k], strain[0, 1, k], strain[0, 2, k] = weight * left0, weight * left1, weight * left2
            for b in range(count):
                ib = net.ring_node[begin + b]
                if ia < ib:
                    continue
                for k in range(3):
                    for d in range(3):
                        if ia > ib or k >= d:
                            band[3 * ib + d, 3 * (ia - ib) + k - d] += (
                                strain[0, 0, k] * ring[b, 0, d]
                                + strain[0, 1, k] * ring[b, 1, d]
                                + strain[0, 2, k] * ring[b, 2, d]
                            )
    own = np.empty(3)
    for f in range(len(net.faces)):
        g = cloth.gradient[0, f]
        area = cloth.area[0, f]
        side = sides[f]
        fu, fv = side[0:3], side[3:6]
        stress_of(side[12:18], law, s, own)
        _tangent(side[12:18], law, s, rate, tangent)
        i0, i1, i2 = net.faces[f, 0], net.faces[f, 1], net.faces[f, 2]
        suu = (1.0 - OWN_SHARE) / 3.0 * (stress[i0, 0] + stress[i1, 0] + stress[i2, 0]) + OWN_SHARE * own[0]
        svv = (1.0 - OWN_SHARE) / 3.0 * (stress[i0, 1] + stress[i1, 1] + stress[i2, 1]) + OWN_SHARE * own[1]
        suv = (1.0 - OWN_SHARE) / 3.0 * (stress[i0, 2] + stress[i1, 2] + stress[i2, 2]) + OWN_SHARE * own[2]
        if tension_only:
            middle, half = 0.5 * (suu + svv), 0.5 * (suu - svv)
            radius = np.sqrt(half * half + suv * suv)
            high, low = middle + radius, middle - radius
            if low < 0.0:
                if high <= 0.0:
                    suu = svv = suv = 0.0
                else:  # the part of the positive principal stress
                    share = high / max(2.0 * radius, 1e-30)
                    suu, svv, suv = share * (half + radius), share * (radius - half), share * suv
        for c in range(3):
            for k in range(3):
                strain[c, 0, k] = g[c, 0] * fu[k]
                strain[c, 1, k] = g[c, 1] * fv[k]
                strain[c, 2, k] = g[c, 0] * fv[k] + g[c, 1] * fu[k]
        if airy or added != 0.0:
            nx, ny, nz = fu[1] * fv[2] - fu[2] * fv[1], fu[2] * fv[0] - fu[0] * fv[2], fu[0] * fv[1] - fu[1] * fv[0]
            size = 1.0 / max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
            normal = (nx * size, ny * size, nz * size)
            through, square = 0.0, 0.0
            for k in range(3):
                w = (v[net.faces[f, 0], k] + v[net.faces[f, 1], k] + v[net.faces[f, 2], k]) / 3.0 - s[WIND_X + k]
                through += w * normal[k]
                square += w * w
            speed = np.sqrt(max(square - through * through, 0.0))
            across = area / 9.0 * (2.0 * s[AIR_NORMAL] * abs(through) * rate + added * mass_rate)
            along = area / 9.0 * s[AIR_SKIN] * speed * rate
            for a in range(3):
                for b in range(3):
                    both[a, b] = (across - along) * normal[a] * normal[b] + (along if a == b else 0.0)
        inertia = mass_rate * cloth.inertia[0, f]
        for ci in range(3):
            i = net.faces[f, ci]
            for cj in range(3):
                j = net.faces[f, cj]
                if i < j:
                    continue
                weight = area * (
                    g[ci, 0] * (suu * g[cj, 0] + suv * g[cj, 1]) + g[ci, 1] * (suv * g[cj, 0] + svv * g[cj, 1])
                )
                for a in range(3):
                    left0 = left1 = left2 = 0.0
                    for d in range(3):
                        left0 += strain[ci, d, a] * tangent[d, 0]
                        left1 += strain[ci, d, a] * tangent[d, 1]
                        left2 += strain[ci, d, a] * tangent[d, 2]
                    for b in range(3):
                        block[a, b] = (
                            OWN_SHARE
                            * area
                            * (left0 * strain[cj, 0, b] + left1 * strain[cj, 1, b] + left2 * strain[cj, 2, b])
                        )
                    block[a, a] += weight + (inertia if i != j else -2.0 * inertia)
                if airy or added != 0.0:
                    for a in range(3):
                        for b in range(3):
                            block[a, b] += both[a, b]
                _add_block(band, i, j, block)
    for c in range(len(net.first) - 1):
        begin, end = net.first[c], net.first[c + 1]
        uu, vv, uv = cloth.bend[0, c, 0], cloth.bend[0, c, 1], cloth.bend[0, c, 2]
        firm, ripples = cloth.ripple[0, c], min(end - begin - 6, net.ripple.shape[1])
        nx, ny, nz = normal_of(x, net, c)
        for a in range(begin, end):
            i = net.node[a]
            wuu, wvv, wuv = uu * net.second[a, 0], vv * net.second[a, 1], uv * net.second[a, 2]
            for b in range(begin, end):
                j = net.node[b]
                if i < j:
                    continue
                value = wuu * net.second[b, 0] + wvv * net.second[b, 1] + wuv * net.second[b, 2]
                slow = tau * rate * value  # acts along the normal alone
                for e in range(ripples):
                    value += firm * net.ripple[a, e] * net.ripple[b, e]
                block[0, 0], block[1, 1], block[2, 2] = (
                    value + slow * nx * nx,
                    value + slow * ny * ny,
                    value + slow * nz * nz,
                )
                block[0, 1] = block[1, 0] = slow * nx * ny
                block[0, 2] = block[2, 0] = slow * nx * nz
                block[1, 2] = block[2, 1] = slow * ny * nz
                _add_block(band, i, j, block)
        if s[HYSTERESIS] != 0.0:
            _add_friction(x, net, cloth, curvature, moment, c, block, band)
    if not np.isnan(s[TABLE_Z]):
        for i in range(len(x)):
            gap = x[i, 2] - s[TABLE_Z]
            if gap < 0.0:
                area = cloth.vertex_area[0, i]
                band[3 * i + 2, 0] += CONTACT_N_M3 * area
                press = -gap * CONTACT_N_M3 * area
                square = v[i, 0] * v[i, 0] + v[i, 1] * v[i, 1]
                grow = press / np.sqrt(square + sliding * sliding) * rate
                if s[STICTION] != 1.0:
                    grow *= 1.0 + (s[STICTION] - 1.0) * np.exp(-square / s[STRIBECK] ** 2)
                band[3 * i, 0] += s[FRICTION_X] * grow
                band[3 * i + 1, 0] += s[FRICTION_Y] * grow
    for h in range(len(net.held)):
        if held_on[h]:
            for k in range(3):
                band[3 * net.held[h] + k, 0] += 1.0 / GRIP_M_N
