"""The cloths of the comparison: a square sheet, a sheet folded over itself, newton's shirt; and newton models of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

EXTENT_M = 0.6  # of the sheet
MODULUS_N_M = 100.0  # both Lame moduli of the membrane
RIGIDITY_N_M = 5.0e-5  # of bending
GRAVITY_M_S2 = 9.81


@dataclass(frozen=True, kw_only=True)
class Cloth:
    """A mesh, where it starts and what is held."""

    name: str
    rest_m: np.ndarray  # (v, 3)
    start_m: np.ndarray  # (v, 3)
    faces: np.ndarray  # (t, 3)
    density_kg_m2: float
    held: tuple[int, ...] = ()  # vertices that do not move by themselves

    @property
    def edges(self) -> np.ndarray:
        """All edges once, (e, 2)."""
        sides = np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        return np.unique(sides, axis=0)

    @property
    def edge_length_m(self) -> np.ndarray:
        """Rest lengths of `edges`, (e,)."""
        ends = self.rest_m[self.edges]
        return np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)

    @property
    def area_m2(self) -> float:
        """Area at rest."""
        a, b, c = (self.rest_m[self.faces[:, i]] for i in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def square(count: int, density_kg_m2: float = 2.0) -> Cloth:
    """Horizontal sheet of `count` x `count` vertices at 1 m, held at its last corner; diagonals alternate."""
    x, y = np.meshgrid(np.linspace(0, EXTENT_M, count), np.linspace(0, EXTENT_M, count))
    points = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(count - 1), np.arange(count - 1), indexing="ij")
    a = row * count + column
    odd = ((row + column) % 2 == 1)[..., None, None]
    one = np.stack([np.stack([a, a + 1, a + count], -1), np.stack([a + 1, a + count + 1, a + count], -1)], -2)
    two = np.stack([np.stack([a, a + 1, a + count + 1], -1), np.stack([a, a + count + 1, a + count], -1)], -2)
    faces = np.where(odd, one, two).reshape(-1, 3).astype(np.int32)
    return Cloth(
        name=f"sheet {count} x {count}",
        rest_m=points,
        start_m=points,
        faces=faces,
        density_kg_m2=density_kg_m2,
        held=(count * count - 1,),
    )


def folded(count: int, gap_m: float) -> Cloth:
    """The sheet folded at the middle of x, two layers `gap_m` apart over a table at z = 0, joined by a half circle."""
    flat = square(count, density_kg_m2=0.3)
    along = flat.rest_m[:, 0] - 0.5 * EXTENT_M
    radius = 0.5 * gap_m
    bend = 0.5 * np.pi * radius  # half the arc: the crease takes this length of each layer
    angle = np.clip(along, -bend, bend) / radius
    out = np.maximum(np.abs(along) - bend, 0.0)
    x = radius * np.cos(angle) - out
    z = 0.003 + radius * (1.0 + np.sin(angle))
    start = np.stack([x, flat.rest_m[:, 1] - 0.5 * EXTENT_M, z], axis=1)
    return replace(flat, name=f"folded sheet {count} x {count}", start_m=start, held=())


def shirt() -> Cloth:
    """`unisex_shirt.usd` of the newton package in metres, z up, held at its highest vertex."""
    import newton.examples
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(newton.examples.get_asset("unisex_shirt.usd"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/root/shirt"))
    points = np.array(mesh.GetPointsAttr().Get(), float) * UsdGeom.GetStageMetersPerUnit(stage)
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3).astype(np.int32)
    points = points[:, [2, 0, 1]]  # the file is y up with the front towards z
    return Cloth(
        name="shirt",
        rest_m=points,
        start_m=points,
        faces=faces,
        density_kg_m2=0.2,
        held=(int(points[:, 2].argmax()),),
    )


def newton_model(
    cloth: Cloth,
    *,
    modulus_n_m: float = MODULUS_N_M,
    style3d: bool = False,
    worlds: int = 1,
    table: bool = False,
    radius_m: float = 0.002,
    device: str = "cpu",
) -> Any:
    """A finalized newton model of `worlds` copies of a cloth; positions at rest, see `Cloth.start_m` for the start."""
    import newton
    import warp as wp

    wp.config.log_level = wp.LOG_ERROR
    one = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY_M_S2))
    shared: dict[str, Any] = {
        "vertices": [wp.vec3(*map(float, point)) for point in cloth.rest_m],
        "indices": cloth.faces.reshape(-1).tolist(),
        "pos": wp.vec3(0.0),
        "rot": wp.quat_identity(),
        "vel": wp.vec3(0.0),
        "density": cloth.density_kg_m2,
        "particle_radius": radius_m,
    }
    if style3d:
        newton.solvers.SolverStyle3D.register_custom_attributes(one)
        # Its membrane knows warp, weft and shear alone: lambda + 2 mu, twice, and mu; no coupling of warp and weft.
        newton.solvers.style3d.add_cloth_mesh(
            one,
            **shared,
            **(_pattern(cloth) if np.ptp(cloth.rest_m[:, 2]) > 1e-9 else {}),
            tri_aniso_ke=wp.vec3(3.0 * modulus_n_m, 3.0 * modulus_n_m, modulus_n_m),
            edge_aniso_ke=wp.vec3(RIGIDITY_N_M, RIGIDITY_N_M, RIGIDITY_N_M),
        )
    else:
        one.add_cloth_mesh(
            **shared,
            scale=1.0,
            tri_ke=modulus_n_m,
            tri_ka=modulus_n_m,
            tri_kd=0.0,
            edge_ke=RIGIDITY_N_M / float(np.median(cloth.edge_length_m)),
            edge_kd=0.0,
        )
        one.color()
    builder = one
    if worlds > 1:
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY_M_S2))
        builder.replicate(one, worlds)
    if table:
        material = newton.ModelBuilder.ShapeConfig(ke=300.0, kd=0.0, mu=0.5, margin=0.0, density=0.0)
        place = wp.transform((0.0, 0.0, -0.1), wp.quat_identity())
        builder.add_shape_box(-1, xform=place, hx=1.5, hy=1.5, hz=0.1, cfg=material)
    model = builder.finalize(device=device)
    flags = model.particle_flags.numpy()
    for held in held_in(cloth, worlds):
        flags[held] &= ~int(newton.ParticleFlags.ACTIVE)
    model.particle_flags.assign(flags)
    return model


def held_in(cloth: Cloth, worlds: int) -> Sequence[int]:
    """Indices of the held vertices in a model of `worlds` copies."""
    return [world * len(cloth.rest_m) + vertex for world in range(worlds) for vertex in cloth.held]


def _pattern(cloth: Cloth) -> dict[str, Any]:
    """Flat pattern for Style3D: every triangle laid flat on its own, first edge along x."""
    a, b, c = (cloth.rest_m[cloth.faces[:, i]] for i in range(3))
    length = np.linalg.norm(b - a, axis=1)
    along = (b - a) / length[:, None]
    x = np.einsum("ij,ij->i", c - a, along)
    y = np.linalg.norm(c - a - x[:, None] * along, axis=1)
    zero = np.zeros_like(x)
    corners = np.stack([np.stack([zero, zero], -1), np.stack([length, zero], -1), np.stack([x, y], -1)], axis=1)
    return {
        "panel_verts": corners.reshape(-1, 2).tolist(),
        "panel_indices": np.arange(3 * len(cloth.faces)).tolist(),
    }
