"""The stiff part, compiled: membrane forces, contact, and the explicit step that carries them.

All in one file, as numba's cache of a function does not see changes in other files that it calls into.
"""

import numpy as np
from numba import njit


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def _edges(x, v, ahead, inverse, damping, uneven, strain, way, rate):
    """Strain plus damped rate of every edge from k to k + ahead, its vector and its relative velocity.

    `uneven` (count,) is the strain at which an edge is at rest.
    """
    for k in range(x.shape[1] - ahead):
        a0, a1, a2 = x[0, k + ahead] - x[0, k], x[1, k + ahead] - x[1, k], x[2, k + ahead] - x[2, k]
        b0, b1, b2 = v[0, k + ahead] - v[0, k], v[1, k + ahead] - v[1, k], v[2, k + ahead] - v[2, k]
        green = 0.5 * ((a0 * a0 + a1 * a1 + a2 * a2) * inverse - 1)
        strain[k] = green - uneven[k] + damping * (a0 * b0 + a1 * b1 + a2 * b2) * inverse
        way[0, k], way[1, k], way[2, k] = a0, a1, a2
        rate[0, k], rate[1, k], rate[2, k] = b0, b1, b2


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def _stiffen(ahead, inverse, growth, straight, uneven, way, strain):
    """Let the secant modulus of edges that are pulled grow with their strain.

    Along each thread by itself: did what couples warp and weft grow too, the stress would have no potential, and a cycle of strain would
    make or lose energy.
    """
    for k in range(len(strain) - ahead):
        square = way[0, k] * way[0, k] + way[1, k] * way[1, k] + way[2, k] * way[2, k]
        pulled = max(0.5 * (square * inverse - 1) - uneven[k], 0.0)
        strain[k] *= 1 + straight * (1 - np.exp(-growth * pulled / straight))


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def membrane_force(x, v, slow, uu, vv, uv, shear, uneven_u, uneven_v, metric, stride, w_edge, w_cell, force):
    """Total force (3, count): slow plus membrane. `metric` is 1/rest^2 of u, of v, their root product, damping, growth, straight."""
    count = x.shape[1]
    inverse_u, inverse_v, inverse_uv = metric[0], metric[1], metric[2]
    damping, growth, straight = metric[3], metric[4], metric[5]
    du, dv, ru, rv = w_edge[0:3], w_edge[3:6], w_edge[6:9], w_edge[9:12]
    su, sv, tu, tv = w_edge[12], w_edge[13], w_edge[14], w_edge[15]
    pp, qq, cu, cv = w_cell[0:3], w_cell[3:6], w_cell[6], w_cell[7]
    _edges(x, v, 1, inverse_u, damping, uneven_u, su, du, ru)
    _edges(x, v, stride, inverse_v, damping, uneven_v, sv, dv, rv)
    for k in range(count - stride - 1):
        cu[k] = 0.5 * uv[k] * (sv[k] + sv[k + 1])
        cv[k] = 0.5 * uv[k] * (su[k] + su[k + stride])
        angle, turn = 0.0, 0.0
        for i in range(3):
            a, b = 0.5 * (du[i, k] + du[i, k + stride]), 0.5 * (dv[i, k] + dv[i, k + 1])
            c, d = 0.5 * (ru[i, k] + ru[i, k + stride]), 0.5 * (rv[i, k] + rv[i, k + 1])
            angle += a * b
            turn += c * b + a * d
        pull = 0.5 * inverse_uv * inverse_uv * shear[k] * (angle + damping * turn)
        for i in range(3):
            a, b = 0.5 * (du[i, k] + du[i, k + stride]), 0.5 * (dv[i, k] + dv[i, k + 1])
            pp[i, k], qq[i, k] = pull * (a + b), pull * (a - b)
    if growth > 0.0:
        _stiffen(1, inverse_u, growth, straight, uneven_u, du, su)
        _stiffen(stride, inverse_v, growth, straight, uneven_v, dv, sv)
    for k in range(stride, count - stride):
        tu[k] = 0.5 * inverse_u * ((uu[k - stride] + uu[k]) * su[k] + cu[k - stride] + cu[k])
        tv[k] = 0.5 * inverse_v * ((vv[k - 1] + vv[k]) * sv[k] + cv[k - 1] + cv[k])
    for i in range(3):
        for k in range(stride + 1, count - stride - 1):
            force[i, k] = (
                slow[i, k]
                + tu[k] * du[i, k]
                - tu[k - 1] * du[i, k - 1]
                + tv[k] * dv[i, k]
                - tv[k - stride] * dv[i, k - stride]
                + (pp[i, k] - pp[i, k - stride - 1])
                + (qq[i, k - 1] - qq[i, k - stride])
            )


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def _touch(x, v, inverse_mass, dt, contact, carried):
    """Change the velocities (3, count) so that no vertex passes the table; see `benchmarks.concealed.table.Contact.arrays`.

    Friction in two directions follows maximum dissipation over an ellipse: the force is normal to the ellipse of the forces
    allowed, not opposite to the velocity. Sticking is a state (Karnopp): a vertex that stuck in the last step holds up to
    `static_ratio` times the sliding friction.
    """
    law, sticking, missing, pressed = contact
    level, mu_x, mu_y, static_ratio, fast_ratio = law[0], law[1], law[2], law[3], law[4]
    fading, stribeck, mu = law[5], law[6], law[7]
    for k in range(x.shape[1]):
        if inverse_mass[k] == 0.0:
            continue
        lowest = (level - x[2, k]) / dt
        if v[2, k] >= lowest:
            sticking[k] = False
            continue
        mass = 1 / inverse_mass[k]
        normal = mass * (lowest - v[2, k])
        if carried.shape[1] == x.shape[1] and carried[3, k] != 0.0:  # the table pushes the air that is carried, too
            less = carried[3, k] * carried[2, k]
            normal = (lowest - v[2, k]) / (inverse_mass[k] - less * carried[2, k])
            v[0, k] -= normal * less * carried[0, k]
            v[1, k] -= normal * less * carried[1, k]
        v[2, k] = lowest
        pressed[k] += normal
        wx, wy = v[0, k], v[1, k]
        speed = np.sqrt(wx * wx + wy * wy)
        if speed == 0.0:
            sticking[k] = True
            continue
        share = fast_ratio + (1 - fast_ratio) * np.exp(-speed / fading)
        slow = 1 + (static_ratio - 1) * np.exp(-speed / stribeck)
        share *= slow
        limit_x, limit_y = mu_x * normal * share + 1e-300, mu_y * normal * share + 1e-300
        needed = mass * np.sqrt((wx / limit_x) ** 2 + (wy / limit_y) ** 2)
        allowed = static_ratio / slow if sticking[k] else 1.0
        if needed <= allowed:
            v[0, k], v[1, k] = 0.0, 0.0
            sticking[k] = True
        else:
            length = np.sqrt((limit_x * wx) ** 2 + (limit_y * wy) ** 2)
            v[0, k] -= inverse_mass[k] * limit_x * limit_x * wx / length
            v[1, k] -= inverse_mass[k] * limit_y * limit_y * wy / length
            sticking[k] = False
        if mu_x == mu and mu_y == mu and abs(share - 1) < 1e-12 and abs(allowed - 1) < 1e-12:
            continue  # the baseline's law: the difference of two velocities would be a force of rounding size, not none
        baseline = min(mu * normal * inverse_mass[k] / speed, 1.0)
        missing[0, k] += mass * (v[0, k] - wx * (1 - baseline))
        missing[1, k] += mass * (v[1, k] - wy * (1 - baseline))


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def inner_steps(
    x,
    v,
    slow,
    uu,
    vv,
    uv,
    shear,
    uneven_u,
    uneven_v,
    metric,
    stride,
    w_edge,
    w_cell,
    force,
    inverse_mass,
    dt,
    number,
    keep,
    carried,
    contact,
):
    """`number` steps of symplectic Euler; `keep` is the share of velocity that stays (relaxation only).

    `carried` is (4, count) or empty: a unit normal and how much less than 1/mass its direction is accelerated.
    """
    count = x.shape[1]
    for _ in range(number):
        membrane_force(x, v, slow, uu, vv, uv, shear, uneven_u, uneven_v, metric, stride, w_edge, w_cell, force)
        for i in range(3):
            for k in range(count):
                v[i, k] = v[i, k] + dt * inverse_mass[k] * force[i, k]
        if carried.shape[1] == count:
            for k in range(count):
                normal = force[0, k] * carried[0, k] + force[1, k] * carried[1, k] + force[2, k] * carried[2, k]
                for i in range(3):
                    v[i, k] -= dt * carried[3, k] * normal * carried[i, k]
        if keep < 1.0:
            for i in range(3):
                for k in range(count):
                    if inverse_mass[k] > 0:
                        v[i, k] *= keep
        if contact[0].shape[0] > 0:
            _touch(x, v, inverse_mass, dt, contact, carried)
        for i in range(3):
            for k in range(count):
                x[i, k] += dt * v[i, k]
