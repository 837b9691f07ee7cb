"""The baseline cloth: what a data sheet would say of it, and the grid that it is computed on."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True)
class Cloth:
    """A flat rectangular sheet of isotropic cloth. SI units."""

    size_u_m: float
    size_v_m: float
    area_density_kg_m2: float
    thickness_m: float
    stretch_n_m: float
    """Membrane Young's modulus times thickness."""
    poisson: float
    bending_n_m: float
    """Plate rigidity B: energy per area is B/2 times the squared (Frobenius) norm of the curvature tensor."""
    damping_s: float
    """Kelvin-Voigt time constant of stretch and of bending."""

    @property
    def weight_n(self) -> float:
        """Weight of the whole sheet under 9.81 m/s^2."""
        return self.size_u_m * self.size_v_m * self.area_density_kg_m2 * 9.81


@dataclass(frozen=True)
class Grid:
    """A regular grid of vertices with one ring of ghosts, as one flat axis.

    Vertex (row, column) lies at u = column * du, v = row * dv. Ghosts have no mass and no stiffness: with them, loops over the
    flat axis need no case for the rim.
    """

    columns: int
    rows: int
    du_m: float
    dv_m: float

    @property
    def stride(self) -> int:
        """Flat distance of two rows."""
        return self.columns + 2

    @property
    def count(self) -> int:
        """Length of the flat axis, ghosts included."""
        return (self.rows + 2) * self.stride

    def at(self, row: int, column: int) -> int:
        """Flat index of a vertex, and of the cell and of the two edges that start there."""
        return (row + 1) * self.stride + column + 1

    @cached_property
    def inside(self) -> np.ndarray:
        """(rows * columns,) flat indices of the real vertices, row by row."""
        row, column = np.divmod(np.arange(self.rows * self.columns), self.columns)
        return (row + 1) * self.stride + column + 1

    @cached_property
    def uv_m(self) -> np.ndarray:
        """(rows * columns, 2) material coordinates of the real vertices."""
        row, column = np.divmod(np.arange(self.rows * self.columns), self.columns)
        return np.stack([column * self.du_m, row * self.dv_m], axis=1)

    @cached_property
    def flat_uv_m(self) -> np.ndarray:
        """(count, 2) material coordinates on the flat axis; ghosts continue the grid."""
        row, column = np.divmod(np.arange(self.count), self.stride)
        return np.stack([(column - 1) * self.du_m, (row - 1) * self.dv_m], axis=1)

    @cached_property
    def is_cell(self) -> np.ndarray:
        """(count,) whether a cell starts at this index."""
        row, column = np.divmod(np.arange(self.count), self.stride)
        return (row >= 1) & (row < self.rows) & (column >= 1) & (column < self.columns)

    @cached_property
    def area_m2(self) -> np.ndarray:
        """(count,) area that belongs to each vertex: a quarter of each cell around it; 0 for ghosts."""
        quarter = self.is_cell * (self.du_m * self.dv_m / 4)
        area = quarter.copy()
        for shift in (1, self.stride, self.stride + 1):
            area[shift:] += quarter[:-shift]
        return area


def grid_of(cloth: Cloth, columns: int, rows: int, refine: int) -> Grid:
    """The laboratory's grid: `refine` times as fine per side as a mesh of columns x rows vertices."""
    fine_columns, fine_rows = (columns - 1) * refine + 1, (rows - 1) * refine + 1
    return Grid(fine_columns, fine_rows, cloth.size_u_m / (fine_columns - 1), cloth.size_v_m / (fine_rows - 1))
