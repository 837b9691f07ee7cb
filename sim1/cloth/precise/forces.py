"""Forces on a sheet, for one world: compiled loops.

Membrane: St. Venant-Kirchhoff, Kelvin-Voigt; strain averaged around vertices, so that a coarse mesh bends without having to stretch
(triangles of constant strain lock: node-based smoothing, Liu and Nguyen-Thoi 2009). Bending: see `bending.py`. What the baseline lacks
is in the same loops, with a factor of 0 where it is absent: it costs little, and no effect can be forgotten in the derivative.
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.arrays import (
    ADDED_MASS,
    ADHESION,
    AIR_NORMAL,
    AIR_SKIN,
    CLING,
    COMPLIANCE,
    DAMPING,
    FRICTION_X,
    FRICTION_Y,
    GRAVITY_X,
    STICTION,
    STIFFENING,
    STRIBECK,
    TABLE_Z,
    WIND_X,
)
from sim1.cloth.precise.bending import resist_bending
from sim1.cloth.precise.compiled_code import FLAGS
from sim1.cloth.precise.jaws import GRIP_M_N, grip_count, grip_loads

OWN_SHARE = 0.3  # of the membrane's energy by each face's own strain; the rest by means, which alone are too soft where strain concentrates
CONTACT_N_M3 = 6e4  # pressure per depth: cloth of 0.3 kg/m^2 sinks 0.05 mm into the table


@njit(cache=True, nogil=True, fastmath=FLAGS)
def workspace_of(x, net):
    """Room for what the first pass leaves to the next: of faces (F, 18), of vertices (V, 6) and (V, 3)."""
    return np.empty((len(net.faces), 18)), np.zeros((len(x), 6)), np.empty((len(x), 3))


@njit(cache=True, nogil=True, fastmath=FLAGS)
def stress_of(strain, law, s, out):
    """Membrane stress (uu, vv, uv) [N/m] from strain and strain rate (uu, vv, 2uv each); yarns that are pulled may stiffen."""
    grow, tau = s[STIFFENING], s[DAMPING]
    out[0] = law[0] * strain[0] * (1.0 + grow * max(strain[0], 0.0)) + law[2] * strain[1]
    out[1] = law[1] * strain[1] * (1.0 + grow * max(strain[1], 0.0)) + law[2] * strain[0]
    out[2] = law[3] * strain[2]
    out[0] += tau * (law[0] * strain[3] + law[2] * strain[4])
    out[1] += tau * (law[1] * strain[4] + law[2] * strain[3])
    out[2] += tau * law[3] * strain[5]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def residual(x, v, acc, sliding, net, cloth, p, curvature, moment, crease, target, held_on, out):
    """Inertia less forces (V, 3) [N] of world `p` at shape `x`, velocity `v`, acceleration `acc`.

    `curvature` and `moment` (C, 3) are those of the step before, `crease` (C, 6) the curvature that folds have kept, and how much they ever yielded,
    `target` (H, 3) where grips want their vertices, `sliding` the speed below which friction is regularised [m/s].
    """
    s = cloth.scalar[p]
    mass, vertex_area = cloth.mass[p], cloth.vertex_area[p]
    for i in range(len(x)):
        for k in range(3):
            out[i, k] = mass[i] * (acc[i, k] - s[GRAVITY_X + k])
    # ------------------------------------------------------------------ membrane: strain averaged around vertices
    airy = s[AIR_NORMAL] != 0.0 or s[AIR_SKIN] != 0.0
    added = s[ADDED_MASS]
    law = cloth.law[p]
    sides, strain, stress = workspace_of(x, net)
    for f in range(len(net.faces)):
        i0, i1, i2 = net.faces[f, 0], net.faces[f, 1], net.faces[f, 2]
        g0u, g0v = cloth.gradient[p, f, 0, 0], cloth.gradient[p, f, 0, 1]
        g1u, g1v = cloth.gradient[p, f, 1, 0], cloth.gradient[p, f, 1, 1]
        g2u, g2v = cloth.gradient[p, f, 2, 0], cloth.gradient[p, f, 2, 1]
        uu = vv = uv = 0.0
        duu = dvv = duv = 0.0
        for k in range(3):
            fu = g0u * x[i0, k] + g1u * x[i1, k] + g2u * x[i2, k]
            fv = g0v * x[i0, k] + g1v * x[i1, k] + g2v * x[i2, k]
            du = g0u * v[i0, k] + g1u * v[i1, k] + g2u * v[i2, k]
            dv = g0v * v[i0, k] + g1v * v[i1, k] + g2v * v[i2, k]
            uu += fu * fu
            vv += fv * fv
            uv += fu * fv
            duu += fu * du
            dvv += fv * dv
            duv += fu * dv + du * fv
            sides[f, k], sides[f, 3 + k] = fu, fv
        uu, vv = 0.5 * (uu - 1.0), 0.5 * (vv - 1.0)
        sides[f, 12], sides[f, 13], sides[f, 14] = uu, vv, uv
        sides[f, 15], sides[f, 16], sides[f, 17] = duu, dvv, duv
        third = cloth.area[p, f] / 3.0
        for c in range(3):
            i = net.faces[f, c]
            strain[i, 0] += third * uu
            strain[i, 1] += third * vv
            strain[i, 2] += third * uv
            strain[i, 3] += third * duu
            strain[i, 4] += third * dvv
            strain[i, 5] += third * duv
    for i in range(len(x)):
        size = 1.0 / vertex_area[i]
        for k in range(6):
            strain[i, k] *= size
        stress_of(strain[i], law, s, stress[i])
    own = np.empty(3)
    share = (1.0 - OWN_SHARE) / 3.0
    for f in range(len(net.faces)):
        i0, i1, i2 = net.faces[f, 0], net.faces[f, 1], net.faces[f, 2]
        g = cloth.gradient[p, f]
        area = cloth.area[p, f]
        side = sides[f]
        fux, fuy, fuz, fvx, fvy, fvz = side[0], side[1], side[2], side[3], side[4], side[5]
        stress_of(side[12:18], law, s, own)
        suu = share * (stress[i0, 0] + stress[i1, 0] + stress[i2, 0]) + OWN_SHARE * own[0]
        svv = share * (stress[i0, 1] + stress[i1, 1] + stress[i2, 1]) + OWN_SHARE * own[1]
        suv = share * (stress[i0, 2] + stress[i1, 2] + stress[i2, 2]) + OWN_SHARE * own[2]
        pux, puy, puz = fux * suu + fvx * suv, fuy * suu + fvy * suv, fuz * suu + fvz * suv
        pvx, pvy, pvz = fux * suv + fvx * svv, fuy * suv + fvy * svv, fuz * suv + fvz * svv
        qx = qy = qz = 0.0  # what every corner gets alike
        if airy or added != 0.0:
            nx, ny, nz = fuy * fvz - fuz * fvy, fuz * fvx - fux * fvz, fux * fvy - fuy * fvx
            size = 1.0 / max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
            nx, ny, nz = nx * size, ny * size, nz * size
            if airy:
                wx = (v[i0, 0] + v[i1, 0] + v[i2, 0]) / 3.0 - s[WIND_X]
                wy = (v[i0, 1] + v[i1, 1] + v[i2, 1]) / 3.0 - s[WIND_X + 1]
                wz = (v[i0, 2] + v[i1, 2] + v[i2, 2]) / 3.0 - s[WIND_X + 2]
                through = wx * nx + wy * ny + wz * nz
                tx, ty, tz = wx - through * nx, wy - through * ny, wz - through * nz
                push = s[AIR_NORMAL] * abs(through) * through * area / 3.0
                skin = s[AIR_SKIN] * np.sqrt(tx * tx + ty * ty + tz * tz) * area / 3.0
                qx, qy, qz = push * nx + skin * tx, push * ny + skin * ty, push * nz + skin * tz
            if added != 0.0:
                ax = (acc[i0, 0] + acc[i1, 0] + acc[i2, 0]) / 3.0
                ay = (acc[i0, 1] + acc[i1, 1] + acc[i2, 1]) / 3.0
                az = (acc[i0, 2] + acc[i1, 2] + acc[i2, 2]) / 3.0
                push = added * area / 3.0 * (ax * nx + ay * ny + az * nz)
                qx, qy, qz = qx + push * nx, qy + push * ny, qz + push * nz
        weight = cloth.inertia[p, f]
        qx += weight * (acc[i0, 0] + acc[i1, 0] + acc[i2, 0])
        qy += weight * (acc[i0, 1] + acc[i1, 1] + acc[i2, 1])
        qz += weight * (acc[i0, 2] + acc[i1, 2] + acc[i2, 2])
        weight *= 3.0
        for c in range(3):
            i = net.faces[f, c]
            gu, gv = area * g[c, 0], area * g[c, 1]
            out[i, 0] += gu * pux + gv * pvx + qx - weight * acc[i, 0]
            out[i, 1] += gu * puy + gv * pvy + qy - weight * acc[i, 1]
            out[i, 2] += gu * puz + gv * pvz + qz - weight * acc[i, 2]
    resist_bending(x, v, net, cloth, p, curvature, moment, crease, out)
    # ------------------------------------------------------------------ vertices: table, grips
    if not np.isnan(s[TABLE_Z]):
        for i in range(len(x)):
            gap = x[i, 2] - s[TABLE_Z]
            if gap < s[CLING]:
                press = max(-gap, 0.0) * CONTACT_N_M3 * vertex_area[i]
                cling = s[ADHESION] * vertex_area[i] * min(1.0, 1.0 - gap / s[CLING])
                out[i, 2] -= press - cling
                if press > 0.0:
                    vx, vy = v[i, 0], v[i, 1]
                    square = vx * vx + vy * vy
                    grow = press / np.sqrt(square + sliding * sliding)
                    if s[STICTION] != 1.0:
                        grow *= 1.0 + (s[STICTION] - 1.0) * np.exp(-square / s[STRIBECK] ** 2)
                    out[i, 0] += s[FRICTION_X] * grow * vx
                    out[i, 1] += s[FRICTION_Y] * grow * vy
    load = np.empty((grip_count(net), 3))
    grip_loads(x, net, target, held_on, s[COMPLIANCE], load)
    for h in range(len(net.held)):
        if held_on[h]:
            i = net.held[h]
            for k in range(3):
                out[i, k] += (x[i, k] - target[h, k] - s[COMPLIANCE] * load[net.grip[h], k]) / GRIP_M_N
