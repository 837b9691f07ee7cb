"""How the forces on a sheet answer to its shape: the derivative of `residual`, a banded matrix.

Each force of `forces.py` has its part here or in `bending.py`. Left out is what is small or would make the matrix
unsymmetric: that normals turn (air, curl, folds), that friction turns with the sliding, that adhesion fades. Forces alone say where an
iteration ends.
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
    STICTION,
    STIFFENING,
    STRIBECK,
    TABLE_Z,
    WIND_X,
)
from sim1.cloth.precise.bending import add_bending
from sim1.cloth.precise.compiled_code import FLAGS
from sim1.cloth.precise.forces import CONTACT_N_M3, OWN_SHARE, stress_of, workspace_of
from sim1.cloth.precise.jaws import GRIP_M_N


@njit(cache=True, nogil=True, fastmath=FLAGS)
def derivative(x, v, mass_rate, rate, sliding, net, cloth, curvature, moment, held_on, tension_only, band):
    """Derivative of `residual` of the base over x, where velocity = rate x + ..., acceleration = mass_rate x + ...; into `band`.

    What yielding jaws couple is left out: see `jaws.coupling`.

    With `tension_only` compressed faces keep no geometric part, which makes the matrix positive definite.
    """
    s = cloth.scalar[0]
    blocks = np.zeros(
        (len(net.pair), 9)
    )  # a vertex over another, column by column; unlike the band they stay in the cache
    sides, strain, stress = workspace_of(x, net)
    _strained(x, v, net, cloth, sides, strain)
    _add_rings(net, cloth, rate, sides, strain, stress, blocks)
    _add_faces(v, net, cloth, mass_rate, rate, sides, stress, tension_only, blocks)
    add_bending(x, net, cloth, rate, curvature, moment, blocks)
    _lay_out(net, blocks, band)
    for i in range(len(x)):
        for k in range(3):
            band[3 * i + k, 0] += mass_rate * cloth.mass[0, i]
    if not np.isnan(s[TABLE_Z]):
        _add_table(x, v, cloth, rate, sliding, band)
    for h in range(len(net.held)):
        if held_on[h]:
            for k in range(3):
                band[3 * net.held[h] + k, 0] += 1.0 / GRIP_M_N


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _lay_out(net, blocks, band):
    """Write the lower triangle of `blocks` (B, 9) into `band`, and zeros between."""
    for j in range(len(band)):  # one by one: cleared at once, it would leave the cache
        band[j] = 0.0
    for p in range(len(net.pair)):
        i, j = net.pair[p, 0], net.pair[p, 1]
        for b in range(3):
            for a in range(b if i == j else 0, 3):
                band[3 * j + b, 3 * (i - j) + a - b] = blocks[p, 3 * b + a]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _strained(x, v, net, cloth, sides, strain):
    """What `forces.residual` says of faces, (F, 18): sides (u, v), strain and its rate; and of vertices (V, 6): means of the last two."""
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
                strain[i, k] += share * side[12 + k]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _tangent(strain, law, s, rate, out):
    """Derivative of the stress over the strain, where strain rates grow with it at `rate`: (uu, vv, shear, uu over vv)."""
    slow, twice = 1.0 + s[DAMPING] * rate, 2.0 * s[STIFFENING]
    out[0] = law[0] * (slow + twice * max(strain[0], 0.0))
    out[1] = law[1] * (slow + twice * max(strain[1], 0.0))
    out[2] = law[3] * slow
    out[3] = law[2] * slow


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _add_rings(net, cloth, rate, sides, strain, stress, blocks):
    """Add what strain averaged around a vertex resists with; `stress` (V, 3) is left there."""
    scalar, law = cloth.scalar[0], cloth.law[0]
    most = 3 * np.diff(net.ring_first).max()
    uu, vv, uv = np.empty(most), np.empty(most), np.empty(most)  # by node and axis
    tangent = np.empty(4)
    pair = 0
    for i in range(len(strain)):
        stress_of(strain[i], law, scalar, stress[i])
        _tangent(strain[i], law, scalar, rate, tangent)
        count = net.ring_first[i + 1] - net.ring_first[i]
        for c in range(3 * count):
            uu[c] = vv[c] = uv[c] = 0.0
        for e in range(net.star_first[i], net.star_first[i + 1]):
            f = net.star_face[e]
            share = cloth.area[0, f] / (3.0 * cloth.vertex_area[0, i])
            side, g = sides[f], cloth.gradient[0, f]
            for c in range(3):
                a = 3 * net.star_local[e, c]
                for k in range(3):
                    uu[a + k] += share * g[c, 0] * side[k]
                    vv[a + k] += share * g[c, 1] * side[3 + k]
                    uv[a + k] += share * (g[c, 0] * side[3 + k] + g[c, 1] * side[k])
        weight = (1.0 - OWN_SHARE) * cloth.vertex_area[0, i]
        t0, t1, t2, t3 = weight * tangent[0], weight * tangent[1], weight * tangent[2], weight * tangent[3]
        for a in range(count):
            x, y, z = 3 * a, 3 * a + 1, 3 * a + 2
            ux, uy, uz = t0 * uu[x] + t3 * vv[x], t0 * uu[y] + t3 * vv[y], t0 * uu[z] + t3 * vv[z]
            vx, vy, vz = t1 * vv[x] + t3 * uu[x], t1 * vv[y] + t3 * uu[y], t1 * vv[z] + t3 * uu[z]
            sx, sy, sz = t2 * uv[x], t2 * uv[y], t2 * uv[z]
            for b in range(a + 1):
                block = blocks[net.ring_pair[pair + b]]
                for d in range(3):
                    u, w, s = uu[3 * b + d], vv[3 * b + d], uv[3 * b + d]
                    block[3 * d] += ux * u + vx * w + sx * s
                    block[3 * d + 1] += uy * u + vy * w + sy * s
                    block[3 * d + 2] += uz * u + vz * w + sz * s
            pair += a + 1


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _add_faces(v, net, cloth, mass_rate, rate, sides, stress, tension_only, blocks):
    """Add what a face's own strain and its stress resist with, the air, and the consistent part of the mass."""
    s, law = cloth.scalar[0], cloth.law[0]
    airy = s[AIR_NORMAL] != 0.0 or s[AIR_SKIN] != 0.0
    added = s[ADDED_MASS]
    own, tangent, normal = np.empty(3), np.empty(4), np.empty(3)
    uu, vv, uv = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))  # (corner, axis)
    both = np.zeros((3, 3))
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
            suu, svv, suv = _pulled(suu, svv, suv)
        for c in range(3):
            for k in range(3):
                uu[c, k] = g[c, 0] * fu[k]
                vv[c, k] = g[c, 1] * fv[k]
                uv[c, k] = g[c, 0] * fv[k] + g[c, 1] * fu[k]
        if airy or added != 0.0:
            normal[0], normal[1] = fu[1] * fv[2] - fu[2] * fv[1], fu[2] * fv[0] - fu[0] * fv[2]
            normal[2] = fu[0] * fv[1] - fu[1] * fv[0]
            size = 1.0 / max(np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2), 1e-12)
            through, square = 0.0, 0.0
            for k in range(3):
                normal[k] *= size
                w = (v[i0, k] + v[i1, k] + v[i2, k]) / 3.0 - s[WIND_X + k]
                through += w * normal[k]
                square += w * w
            speed = np.sqrt(max(square - through * through, 0.0))
            across = area / 9.0 * (2.0 * s[AIR_NORMAL] * abs(through) * rate + added * mass_rate)
            along = area / 9.0 * s[AIR_SKIN] * speed * rate
            for a in range(3):
                for b in range(3):
                    both[a, b] = (across - along) * normal[a] * normal[b] + (along if a == b else 0.0)
        inertia = mass_rate * cloth.inertia[0, f]
        weight = OWN_SHARE * area
        for ci in range(3):
            i = net.faces[f, ci]
            hu, hv = area * (g[ci, 0] * suu + g[ci, 1] * suv), area * (g[ci, 0] * suv + g[ci, 1] * svv)
            for cj in range(3):
                j = net.faces[f, cj]
                if i < j:
                    continue
                block = blocks[net.face_pair[f, ci, cj]]
                alike = hu * g[cj, 0] + hv * g[cj, 1] + (inertia if i != j else -2.0 * inertia)
                for a in range(3):
                    of_uu = weight * (tangent[0] * uu[ci, a] + tangent[3] * vv[ci, a])
                    of_vv = weight * (tangent[1] * vv[ci, a] + tangent[3] * uu[ci, a])
                    of_uv = weight * tangent[2] * uv[ci, a]
                    for b in range(3):
                        block[3 * b + a] += both[a, b] + of_uu * uu[cj, b] + of_vv * vv[cj, b] + of_uv * uv[cj, b]
                    block[4 * a] += alike


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _pulled(uu, vv, uv):
    """The part of a stress (uu, vv, uv) that pulls: of its positive principal stresses."""
    middle, half = 0.5 * (uu + vv), 0.5 * (uu - vv)
    radius = np.sqrt(half * half + uv * uv)
    high, low = middle + radius, middle - radius
    if low >= 0.0:
        return uu, vv, uv
    share = max(high, 0.0) / max(2.0 * radius, 1e-30)
    return share * (half + radius), share * (radius - half), share * uv


@njit(cache=True, nogil=True, fastmath=FLAGS)
def _add_table(x, v, cloth, rate, sliding, band):
    """Add the table's push and its friction, of what touches it."""
    s = cloth.scalar[0]
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
