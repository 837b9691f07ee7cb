"""Banded Cholesky of LAPACK, callable from compiled loops.

scipy ships LAPACK with C entry points; they are made known to the compiler by name, so that compiled code can be cached on disk.
"""

import llvmlite.binding
import numpy as np
from numba import njit
from numba.core import types
from numba.extending import get_cython_function_address

for _name in ("dpbtrf", "dpbtrs", "dgbtrf", "dgbtrs"):
    llvmlite.binding.add_symbol(f"sim1_{_name}", get_cython_function_address("scipy.linalg.cython_lapack", _name))

_char, _int, _double = types.CPointer(types.uint8), types.CPointer(types.int32), types.CPointer(types.float64)
_dpbtrf = types.ExternalFunction("sim1_dpbtrf", types.void(_char, _int, _int, _double, _int, _int))
_dgbtrf = types.ExternalFunction("sim1_dgbtrf", types.void(_int, _int, _int, _int, _double, _int, _int, _int))
_dgbtrs = types.ExternalFunction(
    "sim1_dgbtrs", types.void(_char, _int, _int, _int, _int, _double, _int, _int, _double, _int, _int)
)
_dpbtrs = types.ExternalFunction("sim1_dpbtrs", types.void(_char, _int, _int, _int, _double, _int, _double, _int, _int))


@njit(cache=True, nogil=True)
def factor(band: np.ndarray) -> int:
    """Cholesky factor in place of a matrix given as `band[j, i - j]` (n, width + 1); not 0: it is not positive definite."""
    size = np.array([band.shape[0], band.shape[1] - 1, band.shape[1], 0], np.int32)
    lower = np.array([76], np.uint8)  # "L"
    _dpbtrf(lower.ctypes, size.ctypes, size[1:].ctypes, band.ctypes, size[2:].ctypes, size[3:].ctypes)
    return size[3]


@njit(cache=True, nogil=True)
def solve(band: np.ndarray, right: np.ndarray) -> None:
    """Solve in place for each row of `right` (k, n) with a factor made by `factor`."""
    n = band.shape[0]
    size = np.array([n, band.shape[1] - 1, right.shape[0], band.shape[1], n, 0], np.int32)
    lower = np.array([76], np.uint8)
    _dpbtrs(
        lower.ctypes,
        size.ctypes,
        size[1:].ctypes,
        size[2:].ctypes,
        band.ctypes,
        size[3:].ctypes,
        right.ctypes,
        size[4:].ctypes,
        size[5:].ctypes,
    )


@njit(cache=True, nogil=True)
def factor_any(band: np.ndarray, full: np.ndarray, pivot: np.ndarray) -> int:
    """LU factor, into `full` (n, 3 width + 1), of the symmetric matrix `band` that need not be positive definite."""
    n, w = band.shape[0], band.shape[1] - 1
    full[:] = 0.0
    for j in range(n):
        full[j, 2 * w] = band[j, 0]
        for d in range(1, min(w, n - 1 - j) + 1):
            full[j, 2 * w + d] = band[j, d]
            full[j + d, 2 * w - d] = band[j, d]
    size = np.array([n, w, 3 * w + 1, 0], np.int32)
    _dgbtrf(
        size.ctypes,
        size.ctypes,
        size[1:].ctypes,
        size[1:].ctypes,
        full.ctypes,
        size[2:].ctypes,
        pivot.ctypes,
        size[3:].ctypes,
    )
    return size[3]


@njit(cache=True, nogil=True)
def solve_any(full: np.ndarray, pivot: np.ndarray, right: np.ndarray) -> None:
    """Solve in place for each row of `right` (k, n) with a factor made by `factor_any`."""
    n, w = full.shape[0], (full.shape[1] - 1) // 3
    size = np.array([n, w, right.shape[0], 3 * w + 1, n, 0], np.int32)
    plain = np.array([78], np.uint8)  # "N"
    _dgbtrs(
        plain.ctypes,
        size.ctypes,
        size[1:].ctypes,
        size[1:].ctypes,
        size[2:].ctypes,
        full.ctypes,
        size[3:].ctypes,
        pivot.ctypes,
        right.ctypes,
        size[4:].ctypes,
        size[5:].ctypes,
    )
