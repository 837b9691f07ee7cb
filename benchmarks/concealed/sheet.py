"""Mass and stiffness per vertex and cell: what the solver integrates, and what a material effect changes."""

from dataclasses import dataclass, replace

import numpy as np

from benchmarks.concealed.cloth import Cloth, Grid


@dataclass(frozen=True)
class Sheet:
    """A cloth on a grid. Arrays are (grid.count,), 0 at ghosts; those named `_j` are in joules (modulus times area)."""

    grid: Grid
    mass_kg: np.ndarray
    uu_j: np.ndarray
    """Per cell: energy is uu/2 E_uu^2 + vv/2 E_vv^2 + uv E_uu E_vv + shear/2 (2 E_uv)^2, with Green's strain E."""
    vv_j: np.ndarray
    uv_j: np.ndarray
    shear_j: np.ndarray
    growth: float
    """Secant modulus of a stretched thread is 1 + straight (1 - exp(-growth * strain / straight)) times that of a slack one."""
    straight: float
    """How much stiffer than a slack thread a straight one is: 1, twice as stiff."""
    uneven_u: np.ndarray
    """Per edge along u, unlike other arrays at every index: Green's strain of its rest length against the sheet's mean rest spacing."""
    uneven_v: np.ndarray
    """The same along v."""
    scale_u: float
    """Rest size over grid size."""
    scale_v: float
    bend_u_n_m3: np.ndarray
    """Per vertex: rigidity times area, energy is half of it times x_uu^2."""
    bend_v_n_m3: np.ndarray
    twist_n_m3: np.ndarray
    """Per cell: energy is half of it times 2 x_uv^2."""
    damping_s: float


def baseline_sheet(cloth: Cloth, grid: Grid) -> Sheet:
    """Isotropic St. Venant-Kirchhoff membrane in plane stress, and an isotropic plate."""
    area = grid.is_cell * (grid.du_m * grid.dv_m)
    plane = cloth.stretch_n_m / (1 - cloth.poisson**2)
    row, column = np.divmod(np.arange(grid.count), grid.stride)
    within_u = (column > 1) & (column < grid.columns)
    within_v = (row > 1) & (row < grid.rows)
    return Sheet(
        grid=grid,
        mass_kg=cloth.area_density_kg_m2 * grid.area_m2,
        uu_j=plane * area,
        vv_j=plane * area,
        uv_j=plane * cloth.poisson * area,
        shear_j=cloth.stretch_n_m / (2 * (1 + cloth.poisson)) * area,
        growth=0.0,
        straight=1.0,
        uneven_u=np.zeros(grid.count),
        uneven_v=np.zeros(grid.count),
        scale_u=1.0,
        scale_v=1.0,
        bend_u_n_m3=cloth.bending_n_m * grid.area_m2 * within_u,
        bend_v_n_m3=cloth.bending_n_m * grid.area_m2 * within_v,
        twist_n_m3=cloth.bending_n_m * area,
        damping_s=cloth.damping_s,
    )


def clamped(sheet: Sheet, held: np.ndarray) -> Sheet:
    """The sheet with twice the bending stiffness where a grip ends.

    A held vertex with one free neighbour carries the curvature of half a spacing only, since cloth in the grip does not bend;
    without this, a clamped strip is too soft by one order in the spacing.
    """
    inside = np.zeros(sheet.grid.count, dtype=bool)
    inside[held] = True
    ends_u = inside & (np.roll(inside, 1) != np.roll(inside, -1))
    ends_v = inside & (np.roll(inside, sheet.grid.stride) != np.roll(inside, -sheet.grid.stride))
    return replace(sheet, bend_u_n_m3=sheet.bend_u_n_m3 * (1 + ends_u), bend_v_n_m3=sheet.bend_v_n_m3 * (1 + ends_v))


def stable_step_s(sheet: Sheet, damping_s: float, largest_strain: float = 0.06) -> float:
    """Largest safe step of the membrane: symplectic Euler with Kelvin-Voigt damping of the highest mode.

    The highest mode of a row of springs has omega^2 = 4 c^2 / spacing^2, with c the wave speed; a step is stable up to
    2 / omega * (sqrt(1 + zeta^2) - zeta) with zeta = damping * omega / 2.
    """
    grid = sheet.grid
    mass = (sheet.mass_kg / np.where(grid.area_m2 > 0, grid.area_m2, 1))[grid.inside].min()
    area = grid.du_m * grid.dv_m
    stiffest = max(
        sheet.uu_j.max() / (grid.du_m * sheet.scale_u) ** 2, sheet.vv_j.max() / (grid.dv_m * sheet.scale_v) ** 2
    )
    stiffest *= (1 + 2 * sheet.growth * largest_strain) / area
    omega = np.sqrt(1.25 * 4 * stiffest / mass)
    zeta = damping_s * omega / 2
    return float(0.85 * 2 / omega * (np.sqrt(1 + zeta**2) - zeta))
