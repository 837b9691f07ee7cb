"""Many right-hand sides against one banded Cholesky factor, block by block.

LAPACK's `dpbtrs` goes through the whole factor for every right-hand side. A block of columns against all of them at once is work for
BLAS's matrix products (`python -m benchmarks` says how much is saved).
"""

import llvmlite.binding
import numpy as np
from numba import njit
from numba.core import types
from numba.extending import get_cython_function_address

for _name in ("dtrsm", "dgemm"):
    llvmlite.binding.add_symbol(f"sim1_{_name}", get_cython_function_address("scipy.linalg.cython_blas", _name))

_char, _int, _double = types.CPointer(types.uint8), types.CPointer(types.int32), types.CPointer(types.float64)
_dtrsm = types.ExternalFunction(
    "sim1_dtrsm", types.void(_char, _char, _char, _char, _int, _int, _double, _double, _int, _double, _int)
)
_dgemm = types.ExternalFunction(
    "sim1_dgemm",
    types.void(_char, _char, _int, _int, _int, _double, _double, _int, _double, _int, _double, _double, _int),
)

BLOCK = 32  # columns
PLAIN, TURNED, LOWER = np.array([78, 84, 76], np.uint8)  # "N", "T", "L", as BLAS is told


@njit(cache=True, nogil=True)
def solve_many(band: np.ndarray, right: np.ndarray) -> None:
    """Solve in place for each row of `right` (k, n) with a factor L of `lapack.factor` that is `BLOCK` wide or more: L y = right, L^T x = y.

    Stored as `band[j, i - j]` with `width + 1` numbers a column, L(i, j) lies at `j width + i`: a piece inside the band is a matrix of
    leading dimension `width`. Below a block on the diagonal are a rectangle of such rows and, where the band ends, a triangle, which is
    copied, as what follows it in memory belongs to the next column.
    """
    n, width, count = band.shape[0], band.shape[1] - 1, right.shape[0]
    factor, x = band.reshape(-1), right.reshape(-1)
    corner = np.zeros(BLOCK * BLOCK)
    fixed = np.array([count, width, n, BLOCK], np.int32)
    ones = np.array([1.0, -1.0])
    blocks = (n + BLOCK - 1) // BLOCK
    for backwards in range(2):
        for number in range(blocks):
            j = (blocks - 1 - number if backwards else number) * BLOCK
            own = min(BLOCK, n - j)
            below, last = max(min(width - own, n - j - own), 0), max(min(own, n - j - width), 0)
            size = np.array([own, below, last], np.int32)
            at = j * (width + 1)
            for c in range(own):
                for r in range(min(c + 1, last)):
                    corner[c * BLOCK + r] = factor[at + c * width + width + r]
            if not backwards:
                _triangle(PLAIN, factor[at:], size, fixed, ones, x[j:])
            for piece in range(2):  # the rectangle, the triangle
                rows, away = size[1 + piece :], width if piece else own
                under, leading = (corner, fixed[3:]) if piece else (factor[at + own :], fixed[1:])
                if rows[0] == 0:
                    continue
                if backwards:
                    _subtract(TURNED, under, leading, size, rows, fixed, ones, x[j + away :], x[j:])
                else:
                    _subtract(PLAIN, under, leading, rows, size, fixed, ones, x[j:], x[j + away :])
            if backwards:
                _triangle(TURNED, factor[at:], size, fixed, ones, x[j:])


@njit(cache=True, nogil=True)
def _triangle(how, factor, size, fixed, ones, x):
    """Solve with the block on the diagonal, or its transpose."""
    letters = np.array([LOWER, how, PLAIN], np.uint8)  # the last: what is on the diagonal is not one
    _dtrsm(
        letters.ctypes,
        letters.ctypes,
        letters[1:].ctypes,
        letters[2:].ctypes,
        size.ctypes,
        fixed.ctypes,
        ones.ctypes,
        factor.ctypes,
        fixed[1:].ctypes,
        x.ctypes,
        fixed[2:].ctypes,
    )


@njit(cache=True, nogil=True)
def _subtract(how, factor, leading, rows, inner, fixed, ones, source, target):
    """`target` -= factor @ `source`, or factor^T @ `source`: `rows` by `inner` numbers, with leading dimension `leading`."""
    letters = np.array([how, PLAIN], np.uint8)
    _dgemm(
        letters.ctypes,
        letters[1:].ctypes,
        rows.ctypes,
        fixed.ctypes,
        inner.ctypes,
        ones[1:].ctypes,
        factor.ctypes,
        leading.ctypes,
        source.ctypes,
        fixed[2:].ctypes,
        ones.ctypes,
        target.ctypes,
        fixed[2:].ctypes,
    )
