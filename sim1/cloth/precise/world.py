"""Everything that the motion of a recorded sheet depends on, as numbers; and how it becomes arrays for the compiled loops."""

from dataclasses import dataclass

import numpy as np

from sim1.cloth.precise import arrays
from sim1.cloth.precise.mesh import Sheet
from sim1.cloth.precise.smooth_push import pushes

# Of stencils with one ripple and with several, in units of the bending rigidity: chosen so that sheets of 50 to 600 vertices, regular and
# not, vibrate as a fine one does; tests/mismatch/test_mismatch_modes.py holds them to it.
RIPPLE = 60.0, 12.0
INERTIA = 0.5  # of the consistent mass, the rest lumped: waves then travel at their speed up to fourth order
NEVER = 1e9  # a threshold that nothing reaches


@dataclass(frozen=True, kw_only=True)
class World:
    """One set of physics, SI units. The first block is what a good cloth simulator has; the rest is absent by default."""

    area_density_kg_m2: float
    stretch_n_m: float  # Young's modulus x thickness
    poisson: float
    bending_n_m: float  # energy per area = B / 2 * curvature^2
    damping_s: float  # Kelvin-Voigt time constant of stretch and bending
    friction: float = 0.0  # of the table
    table_z_m: float | None = None  # where the middle surface rests
    gravity_m_s2: tuple[float, float, float] = (0.0, 0.0, -9.81)
    air_density_kg_m3: float = 1.2
    places: tuple[tuple[float, ...], ...] = ()  # per grip: shift (3) [m] and turn (3) [rad] of its held vertices

    # What a mesh leaves open: no finding, but a search may move it within its tolerance.
    length_u: float = 1.0  # rest length over the mesh's: facets shorten a bowed sheet
    length_v: float = 1.0
    clamp: float = 2.0  # bending energy of a cell of which half is held
    rim: float = 1.0  # membrane energy of the faces around what a grip holds, where strain concentrates

    air_normal: float = 0.0  # drag coefficients
    air_skin: float = 0.0
    wind_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    added_mass_kg_m2: float = 0.0
    stretch_ratio: float = 1.0  # warp over weft, geometric mean kept
    bending_ratio: float = 1.0
    stiffening: float = 0.0  # relative growth of the modulus per strain
    hysteresis_n: float = 0.0  # friction moment of bending per width
    turn_1_m: float = 4.0  # curvature over which it turns round
    yield_1_m: float = NEVER  # curvature from which folds keep `retained` of what is beyond
    retained: float = 0.0
    curl_1_m: tuple[float, float] = (0.0, 0.0)  # rest curvature along u and v
    scale: tuple[float, float] = (1.0, 1.0)  # true rest size over scanned size
    stiff_patch: tuple[float, float, float, float] = (0.0, 0.0, 0.05, 1.0)  # centre u, v [m], radius [m], factor
    heavy_patch: tuple[float, float, float] = (0.0, 0.0, 0.0)  # centre u, v [m], mass [kg]
    stiction: float = 1.0  # static over sliding friction
    stribeck_m_s: float = 0.01  # sliding faster than this, nothing is left of stiction
    friction_ratio: float = 1.0  # along x over along y, geometric mean kept
    adhesion_pa: float = 0.0
    cling_m: float = 5e-4  # gap over which adhesion fades out
    slip_threshold_n: float = NEVER
    slip_rate_m_n_s: float = 0.0
    compliance_m_n: float = 0.0  # of each grip as a whole
    lag_s: float = 0.0
    clock_offset_s: float = 0.0
    frame_shift_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frame_turn_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frame_centre_m: tuple[float, float, float] = (0.0, 0.0, 0.0)  # about which a search turns the cameras' frame
    tilt_rad: tuple[float, float] = (0.0, 0.0)
    smooth_push: tuple[float, ...] = ()  # of no effect: see `smooth_push.py`


def gravity(world: World) -> np.ndarray:
    """Gravity (3,) with the rig's tilt: Ry(tilt_y) Rx(tilt_x) g."""
    (cx, sx), (cy, sy) = ((np.cos(a), np.sin(a)) for a in world.tilt_rad)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    return about_y @ about_x @ np.array(world.gravity_m_s2)


def pack(
    sheet: Sheet,
    worlds: list[World],
    clamped: np.ndarray | None = None,
    rim: np.ndarray | None = None,
) -> arrays.Cloth:
    """Arrays of P worlds on one mesh; `clamped` (C,) says which stencils lie on the rim of a clamp, `rim` (F,) which faces."""
    rows = [_row(sheet, world, clamped, rim) for world in worlds]
    columns = (np.ascontiguousarray(np.stack(column)) for column in zip(*rows, strict=True))
    return arrays.Cloth(*columns, push=pushes(sheet, [world.smooth_push for world in worlds]))


def _row(sheet: Sheet, world: World, clamped: np.ndarray | None, rim: np.ndarray | None) -> tuple[np.ndarray, ...]:
    scale_u, scale_v = world.scale[0] * world.length_u, world.scale[1] * world.length_v
    grown = scale_u * scale_v
    stencils = sheet.stencils
    gradient = sheet.gradients / np.array([scale_u, scale_v])
    area, vertex_area = sheet.face_area_m2 * grown, sheet.vertex_area_m2 * grown
    if rim is not None and world.rim != 1.0:
        area = np.where(rim, world.rim * area, area)
        vertex_area = np.bincount(sheet.faces.ravel(), np.repeat(area / 3, 3), minlength=len(vertex_area))
    root = np.sqrt(world.stretch_ratio)
    plane = world.stretch_n_m / (1.0 - world.poisson**2)
    law = np.array([plane * root, plane / root, plane * world.poisson, 0.5 * plane * (1.0 - world.poisson)])
    mass = world.area_density_kg_m2 * sheet.vertex_area_m2  # shrinking keeps the mass
    mass = mass + _lump(sheet, world.heavy_patch)
    density = (mass / sheet.vertex_area_m2)[sheet.faces].mean(1)
    inertia = INERTIA / 12.0 * density * sheet.face_area_m2
    turns = np.sqrt(world.bending_ratio) ** np.array([1.0, -1.0, 0.0])
    bend = world.bending_n_m * turns * np.array([scale_u**-4, scale_v**-4, 2.0 * grown**-2])
    soft = _patch(sheet.material_m[stencils.centre], world.stiff_patch)
    bend_area = stencils.area_m2 * grown
    if clamped is not None:  # only the free half of such a cell bends: by the same angle over half the length
        soft = np.where(clamped, world.clamp * soft, soft)
    ripple = np.where(np.diff(stencils.first) == 7, *RIPPLE) * world.bending_n_m / grown**2 * soft * bend_area
    curl = np.zeros((len(bend_area), 3))
    curl[:, 0], curl[:, 1] = world.curl_1_m[0] * scale_u**2, world.curl_1_m[1] * scale_v**2
    s = np.zeros(arrays.SCALARS)
    half = 0.5 * world.air_density_kg_m3
    root = np.sqrt(world.friction_ratio)
    s[arrays.DAMPING] = world.damping_s
    s[arrays.AIR_NORMAL], s[arrays.AIR_SKIN] = half * world.air_normal, half * world.air_skin
    s[arrays.WIND_X : arrays.WIND_Z + 1] = world.wind_m_s
    s[arrays.GRAVITY_X : arrays.GRAVITY_Z + 1] = gravity(world)
    s[arrays.ADDED_MASS] = world.added_mass_kg_m2
    s[arrays.TABLE_Z] = np.nan if world.table_z_m is None else world.table_z_m
    s[arrays.FRICTION_X], s[arrays.FRICTION_Y] = world.friction * root, world.friction / root
    s[arrays.STICTION], s[arrays.STRIBECK] = world.stiction, world.stribeck_m_s
    s[arrays.ADHESION], s[arrays.CLING] = world.adhesion_pa, world.cling_m
    s[arrays.HYSTERESIS], s[arrays.TURN_CURVATURE] = world.hysteresis_n, world.turn_1_m
    s[arrays.YIELD], s[arrays.RETAINED] = world.yield_1_m, world.retained
    s[arrays.COMPLIANCE] = world.compliance_m_n
    s[arrays.SLIP_THRESHOLD], s[arrays.SLIP_RATE] = world.slip_threshold_n, world.slip_rate_m_n_s
    s[arrays.STIFFENING] = world.stiffening
    return (
        s,
        gradient,
        area,
        law,
        mass,
        inertia,
        vertex_area,
        bend[None] * (soft * bend_area)[:, None],
        ripple,
        curl,
        bend_area,
    )


def _patch(point_m: np.ndarray, patch: tuple[float, float, float, float]) -> np.ndarray:
    """Factor at points (n, 2): `factor` inside the radius, 1 outside, smooth over a quarter of the radius."""
    u, v, radius, factor = patch
    away = np.hypot(point_m[:, 0] - u, point_m[:, 1] - v)
    inside = 0.5 * (1.0 - np.tanh((away - radius) / (0.25 * abs(radius) + 1e-6)))
    return np.exp(np.log(max(factor, 1e-3)) * inside)


def _lump(sheet: Sheet, patch: tuple[float, float, float]) -> np.ndarray:
    """Extra mass (V,) around a place: a bell of 15 mm or one cell, whichever is wider, on the mesh."""
    u, v, mass = patch
    if mass == 0.0:
        return np.zeros(len(sheet.material_m))
    wide = max(0.015, 0.8 * np.sqrt(2 * sheet.face_area_m2.mean()))
    bell = np.exp(-0.5 * ((sheet.material_m - np.array([u, v])) ** 2).sum(1) / wide**2) * sheet.vertex_area_m2
    return mass * bell / max(bell.sum(), 1e-12)
