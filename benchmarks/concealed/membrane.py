"""The membrane of one sheet; the compiled part is `benchmarks.concealed.inner`.

The membrane is a staggered difference scheme of the St. Venant-Kirchhoff sheet: Green's strain along u on the u-edges,
along v on the v-edges, shear at the cell centres. Constant strain is exact, no mode without energy is in the plane, and there are
three strains per vertex, so that bending without stretching is not locked. Kelvin-Voigt: stress follows
strain + damping * strain rate.
"""

import numpy as np

from benchmarks.concealed.inner import inner_steps, membrane_force
from benchmarks.concealed.sheet import Sheet
from benchmarks.concealed.table import Contact


class Membrane:
    """The membrane of one sheet with its work space."""

    def __init__(self, sheet: Sheet, held: np.ndarray, damping_s: float | None = None, growth: float | None = None):
        """`held`: flat indices of vertices that follow the grips; they keep the velocity that they are given."""
        grid = sheet.grid
        self._cells = (sheet.uu_j, sheet.vv_j, sheet.uv_j, sheet.shear_j, sheet.uneven_u, sheet.uneven_v)
        rest_u, rest_v = grid.du_m * sheet.scale_u, grid.dv_m * sheet.scale_v
        self._metric = np.array(
            [
                1 / rest_u**2,
                1 / rest_v**2,
                1 / (rest_u * rest_v),
                sheet.damping_s if damping_s is None else damping_s,
                sheet.growth if growth is None else growth,
                sheet.straight,
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
        membrane_force(
            x, v, np.zeros_like(x), *self._cells, self._metric, self._stride, self._edge_work, self._cell_work, out
        )
        return out

    def step(self, x, v, slow, dt: float, number: int, contact: Contact, keep: float = 1.0, carried=None) -> None:
        """Advance x and v (3, count) in place by number * dt under the constant slow force."""
        inner_steps(
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
