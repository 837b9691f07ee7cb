"""The stiff part, compiled: membrane forces and the explicit step that carries them.

The membrane is a staggered difference scheme of the St. Venant-Kirchhoff sheet: Green's strain along u on the u-edges,
along v on the v-edges, shear at the cell centres. Constant strain is exact, no mode without energy is in the plane, and there are
three strains per vertex, so that bending without stretching is not locked. Kelvin-Voigt: stress follows
strain + damping * strain rate.
"""

import numpy as np
from numba import njit

from benchmarks.concealed.sheet import Sheet
from benchmarks.concealed.table import Contact, touch


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def _edges(x, v, ahead, inverse, damping, growth, strain, way, rate):
    """Strain plus damped rate of every edge from k to k + ahead, its vector and its relative velocity."""
    for k in range(x.shape[1] - ahead):
        a0, a1, a2 = x[0, k + ahead] - x[0, k], x[1, k + ahead] - x[1, k], x[2, k + ahead] - x[2, k]
        b0, b1, b2 = v[0, k + ahead] - v[0, k], v[1, k + ahead] - v[1, k], v[2, k + ahead] - v[2, k]
        green = 0.5 * ((a0 * a0 + a1 * a1 + a2 * a2) * inverse - 1)
        strain[k] = (1 + growth * max(green, 0.0)) * (green + damping * (a0 * b0 + a1 * b1 + a2 * b2) * inverse)
        way[0, k], way[1, k], way[2, k] = a0, a1, a2
        rate[0, k], rate[1, k], rate[2, k] = b0, b1, b2


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def _membrane(x, v, slow, uu, vv, uv, shear, metric, stride, w_edge, w_cell, force):
    """Total force (3, count): slow plus membrane. `metric` is 1/rest^2 of u, of v, their root product, damping, growth."""
    count = x.shape[1]
    inverse_u, inverse_v, inverse_uv, damping, growth = metric[0], metric[1], metric[2], metric[3], metric[4]
    du, dv, ru, rv = w_edge[0:3], w_edge[3:6], w_edge[6:9], w_edge[9:12]
    su, sv, tu, tv = w_edge[12], w_edge[13], w_edge[14], w_edge[15]
    pp, qq, cu, cv = w_cell[0:3], w_cell[3:6], w_cell[6], w_cell[7]
    _edges(x, v, 1, inverse_u, damping, growth, su, du, ru)
    _edges(x, v, stride, inverse_v, damping, growth, sv, dv, rv)
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
def _steps(
    x,
    v,
    slow,
    uu,
    vv,
    uv,
    shear,
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
        _membrane(x, v, slow, uu, vv, uv, shear, metric, stride, w_edge, w_cell, force)
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
            touch(x, v, inverse_mass, dt, contact)
        for i in range(3):
            for k in range(count):
                x[i, k] += dt * v[i, k]


class Membrane:
    """The membrane of one sheet with its work space."""

    def __init__(self, sheet: Sheet, held: np.ndarray, damping_s: float | None = None, growth: float | None = None):
        """`held`: flat indices of vertices that follow the grips; they keep the velocity that they are given."""
        grid = sheet.grid
        self._cells = (sheet.uu_j, sheet.vv_j, sheet.uv_j, sheet.shear_j)
        rest_u, rest_v = grid.du_m * sheet.scale_u, grid.dv_m * sheet.scale_v
        self._metric = np.array(
            [
                1 / rest_u**2,
                1 / rest_v**2,
                1 / (rest_u * rest_v),
                sheet.damping_s if damping_s is None else damping_s,
                sheet.growth if growth is None else growth,
            ]
        )
        self._stride = grid.stride
        self._edge_work, self._cell_work = np.zeros((16, grid.count)), np.zeros((8, grid.count))
        self.force_n = np.zeros((3, grid.count))
        """(3, count) total force of the latest evaluation, held vertices too."""
        self._inverse_mass = np.zeros(grid.count)
        self._inverse_mass[grid.inside] = 1 / sheet.mass_kg[grid.inside]
        self._inverse_mass[held] = 0.0

    def forces(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(3, count) membrane force alone."""
        out = np.zeros_like(x)
        _membrane(
            x, v, np.zeros_like(x), *self._cells, self._metric, self._stride, self._edge_work, self._cell_work, out
        )
        return out

    def step(self, x, v, slow, dt: float, number: int, contact: Contact, keep: float = 1.0, carried=None) -> None:
        """Advance x and v (3, count) in place by number * dt under the constant slow force."""
        _steps(
            x,
            v,
            slow,
            *self._cells,
            self._metric,
            self._stride,
            self._edge_work,
            self._cell_work,
            self.force_n,
            self._inverse_mass,
            dt,
            number,
            keep,
            _NOTHING_CARRIED if carried is None else carried,
            contact.arrays,
        )


_NOTHING_CARRIED = np.zeros((4, 0))
