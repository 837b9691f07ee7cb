"""Bending, compiled: the quadratic energy of an isotropic plate on a grid, and signed curvatures with moments."""

import numpy as np
from numba import njit

from benchmarks.concealed.sheet import Sheet


@njit(fastmath=True, nogil=True, cache=True, error_model="numpy")
def _plate(x, v, normal, bend_u, bend_v, twist, damping, du, dv, stride, work, out):
    """Add the force (3, count) of energy sum(bend_u x_uu^2 + bend_v x_vv^2 + 2 twist x_uv^2) / 2 with Kelvin-Voigt damping.

    Of a rate of bending what points along the normal is damped, so that turning stiffly costs nothing.
    """
    count = x.shape[1]
    inverse_u, inverse_v, inverse_uv = 1 / du**2, 1 / dv**2, 1 / (du * dv)
    rate_u, rate_v, rate_t, mu, mv, mt = work[0], work[1], work[2], work[3], work[4], work[5]
    rate_u[:], rate_v[:], rate_t[:] = 0.0, 0.0, 0.0
    for i in range(3):
        for k in range(stride, count - stride):
            rate_u[k] += normal[i, k] * (v[i, k - 1] - 2 * v[i, k] + v[i, k + 1])
            rate_v[k] += normal[i, k] * (v[i, k - stride] - 2 * v[i, k] + v[i, k + stride])
        for k in range(count - stride - 1):
            rate_t[k] += normal[i, k] * (v[i, k] - v[i, k + 1] - v[i, k + stride] + v[i, k + stride + 1])
    for i in range(3):
        for k in range(stride, count - stride):
            n = damping * normal[i, k]
            lean_u = x[i, k - 1] - 2 * x[i, k] + x[i, k + 1] + n * rate_u[k]
            lean_v = x[i, k - stride] - 2 * x[i, k] + x[i, k + stride] + n * rate_v[k]
            mu[k] = bend_u[k] * lean_u * inverse_u * inverse_u
            mv[k] = bend_v[k] * lean_v * inverse_v * inverse_v
        for k in range(count - stride - 1):
            lean = x[i, k] - x[i, k + 1] - x[i, k + stride] + x[i, k + stride + 1] + damping * normal[i, k] * rate_t[k]
            mt[k] = 2 * twist[k] * lean * inverse_uv * inverse_uv
        for k in range(stride + 1, count - stride - 1):
            out[i, k] += (
                (2 * mu[k] - mu[k - 1] - mu[k + 1])
                + (2 * mv[k] - mv[k - stride] - mv[k + stride])
                - (mt[k] - mt[k - 1] - mt[k - stride] + mt[k - stride - 1])
            )


class Plate:
    """The baseline's bending of one sheet: quadratic, as the sheet hardly stretches and |x_uu| is then the curvature."""

    def __init__(self, sheet: Sheet, damping_s: float | None = None):
        """`damping_s` takes the place of the sheet's own, for relaxation."""
        self._cells = (sheet.bend_u_n_m3, sheet.bend_v_n_m3, sheet.twist_n_m3)
        self._damping = sheet.damping_s if damping_s is None else damping_s
        self._spacing = (sheet.grid.du_m * sheet.scale_u, sheet.grid.dv_m * sheet.scale_v)
        self._stride, self._size = sheet.grid.stride, (sheet.grid.rows, sheet.grid.columns)
        self._work = np.zeros((6, sheet.grid.count))
        self._normal = np.zeros((3, sheet.grid.count))

    def add(self, x: np.ndarray, v: np.ndarray, out: np.ndarray) -> None:
        """Add the bending force to out (3, count)."""
        vertex_normals(x, *self._size, self._normal)
        _plate(x, v, self._normal, *self._cells, self._damping, *self._spacing, self._stride, self._work, out)


@njit(nogil=True, cache=True, error_model="numpy")
def vertex_normals(x, rows, columns, out):
    """Unit normals u x v (3, count) at the real vertices, from central differences (one-sided at the rim)."""
    stride = columns + 2
    for row in range(rows):
        for column in range(columns):
            k = (row + 1) * stride + column + 1
            left, right = k - (column > 0), k + (column < columns - 1)
            up, down = k - stride * (row > 0), k + stride * (row < rows - 1)
            a0, a1, a2 = x[0, right] - x[0, left], x[1, right] - x[1, left], x[2, right] - x[2, left]
            b0, b1, b2 = x[0, down] - x[0, up], x[1, down] - x[1, up], x[2, down] - x[2, up]
            n0, n1, n2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
            length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            out[0, k], out[1, k], out[2, k] = n0 / length, n1 / length, n2 / length


@njit(nogil=True, cache=True, error_model="numpy")
def curvatures(x, rows, columns, du, dv, normal, kappa):
    """kappa[0] = x_uu . n and kappa[1] = x_vv . n at the vertices with neighbours on both sides, else 0; fills normal too."""
    stride = columns + 2
    vertex_normals(x, rows, columns, normal)
    for row in range(rows):
        for column in range(columns):
            k = (row + 1) * stride + column + 1
            kappa[0, k], kappa[1, k] = 0.0, 0.0
            for i in range(3):
                if 0 < column < columns - 1:
                    kappa[0, k] += normal[i, k] * (x[i, k - 1] - 2 * x[i, k] + x[i, k + 1]) / du**2
                if 0 < row < rows - 1:
                    kappa[1, k] += normal[i, k] * (x[i, k - stride] - 2 * x[i, k] + x[i, k + stride]) / dv**2


@njit(nogil=True, cache=True, error_model="numpy")
def add_moments(x, moment, rows, columns, du, dv, normal, out):
    """Add the force -sum(moment . d kappa / dx) to out (3, count).

    `moment` (2, count) is the moment per length times the vertex's area, positive where it acts against positive curvature.
    The turning of the normal is kept, so the forces have no resultant and no torque; `normal` as `curvatures` fills it.
    """
    stride = columns + 2
    lean = np.zeros(3)
    a, b = np.zeros(3), np.zeros(3)
    for row in range(rows):
        for column in range(columns):
            k = (row + 1) * stride + column + 1
            left, right = k - (column > 0), k + (column < columns - 1)
            up, down = k - stride * (row > 0), k + stride * (row < rows - 1)
            for axis in range(2):
                if moment[axis, k] == 0.0:
                    continue
                ahead, inverse = (1, 1 / du**2) if axis == 0 else (stride, 1 / dv**2)
                along = 0.0
                for i in range(3):
                    lean[i] = (x[i, k - ahead] - 2 * x[i, k] + x[i, k + ahead]) * inverse
                    along += lean[i] * normal[i, k]
                    a[i], b[i] = x[i, right] - x[i, left], x[i, down] - x[i, up]
                area = 0.0
                for i in range(3):
                    p, q = (i + 1) % 3, (i + 2) % 3
                    area += normal[i, k] * (a[p] * b[q] - a[q] * b[p])
                    lean[i] -= along * normal[i, k]
                m = moment[axis, k]
                for i in range(3):
                    p, q = (i + 1) % 3, (i + 2) % 3
                    out[i, k - ahead] -= m * normal[i, k] * inverse
                    out[i, k + ahead] -= m * normal[i, k] * inverse
                    out[i, k] += 2 * m * normal[i, k] * inverse
                    from_a = m * (b[p] * lean[q] - b[q] * lean[p]) / area
                    from_b = m * (lean[p] * a[q] - lean[q] * a[p]) / area
                    out[i, right] -= from_a
                    out[i, left] += from_a
                    out[i, down] -= from_b
                    out[i, up] += from_b
