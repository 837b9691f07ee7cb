"""Many right-hand sides against one banded Cholesky factor, block by block.

LAPACK's `dpbtrs` goes through the whole factor for every right-hand side. A block of columns against all of them at once is work for
BLAS's matrix products: for a dozen twins less than half of the time, for the seventy of a screening a third.
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
                _triangle(78, factor[at:], size, fixed, ones, x[j:])
            if below > 0:
                _take(backwards, factor[at + own :], fixed[1:], size[1:], size, fixed, ones, x[j:], x[j + own :])
            if last > 0:
                _take(backwards, corner, fixed[3:], size[2:], size, fixed, ones, x[j:], x[j + width :])
            if backwards:
                _triangle(84, factor[at:], size, fixed, ones, x[j:])


@njit(cache=True, nogil=True)
def _triangle(how, factor, size, fixed, ones, x):
    """Solve with the block on the diagonal (78, "N") or its transpose (84, "T")."""
    letters = np.array([76, how, 78], np.uint8)  # "L", how, "N"
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
def _take(backwards, factor, leading, rows, size, fixed, ones, x, other):
    """`other` -= factor @ x, or backwards x -= factor^T @ `other`; `rows` of the factor, leading dimension `leading`."""
    letters = np.array([78, 84], np.uint8)  # "N", "T"
    if backwards:
        _dgemm(
            letters[1:].ctypes,
            letters.ctypes,
            size.ctypes,
            fixed.ctypes,
            rows.ctypes,
            ones[1:].ctypes,
            factor.ctypes,
            leading.ctypes,
            other.ctypes,
            fixed[2:].ctypes,
            ones.ctypes,
            x.ctypes,
            fixed[2:].ctypes,
        )
    else:
        _dgemm(
            letters.ctypes,
            letters.ctypes,
            rows.ctypes,
            fixed.ctypes,
            size.ctypes,
            ones[1:].ctypes,
            factor.ctypes,
            leading.ctypes,
            x.ctypes,
            fixed[2:].ctypes,
            ones.ctypes,
            other.ctypes,
            fixed[2:].ctypes,
        )
