"""A push without a name: a force per area that varies smoothly over the sheet and with the velocity there.

f(s, t, v) = sum over b in (1, s, t) of b (a_b - D_b v), where s and t run from -1 to 1 over the sheet, each a_b has three numbers [Pa] and
each D_b is diagonal [Pa s/m]: 18 numbers. What a generic residual model can be, to measure named physics by; no effect of a model file.
Where no world has it the array holds no world, and nothing is computed.
"""

import numpy as np
from numba import njit

from sim1.cloth.precise.compiled_code import FLAGS
from sim1.cloth.precise.mesh import Sheet

NUMBERS = 18  # by basis function, then push or brake, then axis


def pushes(sheet: Sheet, numbers: list[tuple[float, ...]]) -> np.ndarray:
    """Push [N] and brake [N s/m] at the vertices in each of P worlds, (P, 2, V, 3); of no world where none has any numbers."""
    if not any(numbers):
        return np.empty((0, 2, len(sheet.material_m), 3))
    low, high = sheet.material_m.min(0), sheet.material_m.max(0)
    basis = np.column_stack([np.ones(len(sheet.material_m)), 2.0 * (sheet.material_m - low) / (high - low) - 1.0])
    values = np.reshape([one or (0.0,) * NUMBERS for one in numbers], (-1, 3, 2, 3))
    return np.ascontiguousarray(np.einsum("v,vb,pbka->pkva", sheet.vertex_area_m2, basis, values))


@njit(cache=True, nogil=True, fastmath=FLAGS)
def smooth_push(v, push, p, out):
    """Take the push of world `p` at velocity `v` (V, 3) out of the residual `out` (V, 3)."""
    if len(push) > 0:
        for i in range(len(v)):
            for k in range(3):
                out[i, k] -= push[p, 0, i, k] - push[p, 1, i, k] * v[i, k]


@njit(cache=True, nogil=True, fastmath=FLAGS)
def smooth_push_slope(push, rate, band):
    """Add to the matrix `band` of the base what its brakes answer, where velocity grows with the place at `rate`."""
    if len(push) > 0:
        for i in range(push.shape[2]):
            for k in range(3):
                band[3 * i + k, 0] += rate * push[0, 1, i, k]


@njit(cache=True, nogil=True)
def push_nearer(push, p, shrink):
    """Make the push of a twin differ less from the base's."""
    if len(push) > 0:
        push[p] = push[0] + shrink * (push[p] - push[0])
