"""What a cloth is made of, as flat arrays: triangles, hinges, limited edges."""

from typing import Any

import numpy as np
import warp as wp


@wp.struct
class Sheet:
    """The cloth's structure; nothing in it changes during the sweeps of a step. Effects of bending shift `hinge_angle` before."""

    mass: wp.array(dtype=float)  # [kg], (v,)
    movable: wp.array(dtype=wp.int32)  # (v,), 0: held
    triangle: wp.array(dtype=wp.vec3i)  # (t,) vertices
    triangle_pose: wp.array(dtype=wp.mat22)  # (t,) inverse of the rest edges in the material plane [1/m]
    triangle_area: wp.array(dtype=float)  # (t,) at rest [m^2]
    triangle_law: wp.array(dtype=wp.mat33)  # (t,) stress over strain, Voigt (11, 22, 12 with 2 G12) [N/m]
    triangle_viscosity: wp.array(dtype=float)  # (t,) kd: viscous stress = 4 kd dG/dt [N s/m]
    slack: float  # share of compressive strain that makes stress
    growth: float  # of the modulus along each material axis per strain, where it is pulled; 0: the law is linear
    hinge: wp.array(dtype=wp.vec4i)  # (h,) opposite, opposite, start, end
    hinge_angle: wp.array(dtype=float)  # (h,) at rest [rad]
    hinge_stiffness: wp.array(dtype=float)  # (h,) energy 1/2 k (angle - rest)^2 [N m]
    hinge_damping: wp.array(dtype=float)  # (h,) moment over angular speed [N m s]
    edge: wp.array(dtype=wp.vec2i)  # (e,) ends of the edges under the strain limit
    edge_length: wp.array(dtype=float)  # (e,) at rest [m]


@wp.struct
class Part:
    """A triangle as one of the blocks that hold some of its corners sees it: all it needs, side by side in memory.

    With b1, b2 the change of the deformation gradient's columns with the block [1/m], A the area, C the law, S the stress:
    what moves the block is A (S11 b1 + S12 b2, S12 b1 + S22 b2) in the columns' basis.
    """

    triangle: wp.int32
    corner: wp.vec3i
    pose: wp.mat22
    slope: wp.vec2  # b1, b2 [1/m]
    first: wp.vec3  # S11 b1 + S12 b2 over strain, times the area [N]
    second: wp.vec3  # S12 b1 + S22 b2 over strain, times the area [N]
    firmness: wp.vec3  # A (g1 C g1, g1 C g2, g2 C g2), g1 = (b1, 0, b2) and g2 = (0, b2, b1) the strain's changes [N/m]
    viscosity: float  # 4 A kd [N m s]
    lean: float  # g = (C11 / C22)^(1/4): in strains (g^2 G11, G22, g G12) the law of a weave is isotropic
    beside: float  # C12 over C11 of that isotropic law
    single: float  # A E / 2 of it, of a strip that nothing holds sideways [N m]


def sheet_of(model: Any, slack: float) -> Sheet:
    """Read the cloth of a finalized newton model.

    Raises:
        ValueError: the model holds springs or tetrahedra, which this solver does not simulate, or no triangle.
    """
    for name in ("spring", "tet"):
        if getattr(model, f"{name}_count"):
            raise ValueError(
                f"the model has {getattr(model, f'{name}_count')} {name}s; this solver simulates triangles"
            )
    if not model.tri_count:
        raise ValueError("the model has no triangles; add cloth with ModelBuilder.add_cloth_mesh or add_cloth_grid")
    triangles = model.tri_indices.numpy().reshape(-1, 3).astype(np.int32)
    edges = model.edge_indices.numpy().reshape(-1, 4).astype(np.int32)
    inner = (edges[:, 0] >= 0) & (edges[:, 1] >= 0)
    bending = model.edge_bending_properties.numpy().reshape(-1, 2)[inner]
    length = model.edge_rest_length.numpy()
    materials = model.tri_materials.numpy().reshape(len(triangles), -1)

    sheet = Sheet()
    device = model.device

    def put(values: np.ndarray, dtype: Any) -> wp.array:
        return wp.array(np.ascontiguousarray(values), dtype=dtype, device=device)

    sheet.mass = model.particle_mass
    sheet.movable = wp.zeros(model.particle_count, dtype=wp.int32, device=device)
    sheet.triangle = put(triangles, wp.vec3i)
    sheet.triangle_pose = model.tri_poses
    sheet.triangle_area = model.tri_areas
    sheet.triangle_law = put(isotropic_law(materials[:, 0], materials[:, 1]), wp.mat33)
    sheet.triangle_viscosity = put(materials[:, 2].astype(np.float32), float)
    sheet.slack, sheet.growth = slack, 0.0
    sheet.hinge = put(edges[inner], wp.vec4i)
    sheet.hinge_angle = put(model.edge_rest_angle.numpy()[inner], float)
    sheet.hinge_stiffness = put(bending[:, 0] * length[inner], float)
    sheet.hinge_damping = put(bending[:, 1] * length[inner], float)
    sheet.edge = put(edges[:, 2:], wp.vec2i)
    sheet.edge_length = put(length, float)
    return sheet


def parts_of(sheet: Sheet, triangle: np.ndarray, slope: np.ndarray) -> wp.array:
    """Triangles (n,) as blocks see them along which the deformation gradient's columns change by `slope` (n, 2) [1/m]."""
    parts = np.zeros(len(triangle), dtype=Part.numpy_dtype())
    parts["triangle"], parts["slope"] = triangle, slope
    parts["corner"], parts["pose"] = sheet.triangle.numpy()[triangle], sheet.triangle_pose.numpy()[triangle]
    area = sheet.triangle_area.numpy()[triangle].astype(float)
    law = sheet.triangle_law.numpy()[triangle].astype(float)
    b1, b2 = slope.T.astype(float)
    still = np.zeros_like(b1)
    with_first = np.stack([b1, still, b2], axis=-1)  # change of the strain (11, 22, 2 12) along the first column
    with_second = np.stack([still, b2, b1], axis=-1)
    parts["first"] = area[:, None] * np.einsum("nij,ni->nj", law, with_first)
    parts["second"] = area[:, None] * np.einsum("nij,ni->nj", law, with_second)
    pairs = ((with_first, with_first), (with_first, with_second), (with_second, with_second))
    parts["firmness"] = area[:, None] * np.stack([np.einsum("ni,nij,nj->n", a, law, b) for a, b in pairs], axis=-1)
    parts["viscosity"] = 4.0 * area * sheet.triangle_viscosity.numpy()[triangle]
    mean = np.sqrt(law[:, 0, 0] * law[:, 1, 1])
    square = np.divide(mean, law[:, 1, 1], out=np.ones(len(law)), where=mean > 0.0)  # g^2
    parts["lean"] = np.sqrt(square)
    parts["beside"] = np.divide(law[:, 0, 1], mean, out=np.zeros(len(law)), where=mean > 0.0)
    parts["single"] = 0.5 * area * (mean - parts["beside"] * law[:, 0, 1]) / square
    return wp.array(parts, dtype=Part)


def isotropic_law(mu_n_m: np.ndarray, lambda_n_m: np.ndarray) -> np.ndarray:
    """Stress over Green strain (t, 3, 3) of an isotropic St. Venant-Kirchhoff membrane, Voigt with engineering shear."""
    law = np.zeros((len(mu_n_m), 3, 3), dtype=np.float32)
    law[:, 0, 0] = law[:, 1, 1] = lambda_n_m + 2.0 * mu_n_m
    law[:, 0, 1] = law[:, 1, 0] = lambda_n_m
    law[:, 2, 2] = mu_n_m
    return law
