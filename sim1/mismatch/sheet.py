"""A held sheet of cloth without contact: the small, accurate simulator that identification needs.

Membrane: isotropic St. Venant-Kirchhoff, constant strain per triangle. Bending: the second derivatives of the shape over
material coordinates, fitted around every vertex; quadratic, as the rest shape is flat and cloth bends almost without
stretching (Bergou et al. 2006). Damping: Kelvin-Voigt, one time constant for both. Air: normal and tangential drag of each face.
A game-like solver of the pipeline would damp a swing by several percent a second, which would be read as a material.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Material:
    """What a simulation of a held sheet depends on; SI units."""

    area_density_kg_m2: float
    stretch_n_m: float  # Young's modulus x thickness
    poisson: float
    bending_n_m: float  # energy per area = B / 2 * curvature^2
    damping_s: float  # Kelvin-Voigt time constant of stretch and bending
    c_normal: float = 0.0  # pressure drag of still air, 0: none
    c_tangential: float = 0.0  # skin drag of still air
    air_density_kg_m3: float = 1.2


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A flat rest mesh: V vertices, F faces."""

    material_m: np.ndarray  # (V, 2) material coordinates
    faces: np.ndarray  # (F, 3)

    @cached_property
    def face_area_m2(self) -> np.ndarray:
        """Rest area of each face, (F,)."""
        a, b, c = (self.material_m[self.faces[:, k]] for k in range(3))
        area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        if (np.abs(area) < 1e-10).any() or ((area > 0).any() and (area < 0).any()):
            face = int(np.argmin(np.abs(area)))
            raise BadInput(f"rest mesh: material coordinates overlap or face {face} has no area ({area[face]:.1e} m^2)")
        return np.abs(area)

    @cached_property
    def gradients(self) -> np.ndarray:
        """Derivatives of the three linear shape functions of each face over (u, v), (F, 3, 2), 1/m."""
        corner = self.material_m[self.faces]
        edges = np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=-1)
        inverse = np.linalg.inv(edges)
        return np.concatenate([-inverse.sum(1, keepdims=True), inverse], axis=1)

    @cached_property
    def vertex_area_m2(self) -> np.ndarray:
        """A third of the faces around each vertex, (V,)."""
        return np.bincount(self.faces.ravel(), np.repeat(self.face_area_m2 / 3, 3), minlength=len(self.material_m))

    @cached_property
    def bending_matrix(self) -> csr_array:
        """Q (V, V) of the bending energy B / 2 * trace(x^T Q x), 1/m^2."""
        count = len(self.material_m)
        ends = np.sort(np.concatenate([self.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
        edges, uses = np.unique(ends, axis=0, return_counts=True)
        inner = np.setdiff1d(np.unique(self.faces), edges[uses == 1])
        if len(inner) == 0:
            raise BadInput(
                f"rest mesh: none of its {count} vertices lies inside; give a mesh of 4 x 4 vertices or more"
            )
        tree = cKDTree(self.material_m)
        fits = {}
        for vertex in inner:
            near = np.unique(edges[(edges == vertex).any(1)])
            fit = _second_derivatives(self.material_m[near] - self.material_m[vertex])
            if fit is None:  # too few neighbours: those around the corner as well
                reach = np.linalg.norm(self.material_m[near] - self.material_m[vertex], axis=1).max()
                near = np.array(sorted(tree.query_ball_point(self.material_m[vertex], 1.5 * reach)))
                fit = _second_derivatives(self.material_m[near] - self.material_m[vertex])
            if fit is not None:
                fits[int(vertex)] = near, fit
        if not fits:
            raise BadInput("rest mesh: no vertex has enough neighbours to bend; give a mesh of 4 x 4 vertices or more")
        centres = np.array(list(fits))
        owner = centres[cKDTree(self.material_m[centres]).query(self.material_m)[1]]
        for vertex in np.setdiff1d(np.arange(count), np.concatenate([near for near, _ in fits.values()])):
            centre = int(
                owner[vertex]
            )  # a corner that no inner vertex touches would flap for free: it joins the nearest fit
            near = np.union1d(fits[centre][0], [vertex])
            fits[centre] = near, _second_derivatives(self.material_m[near] - self.material_m[centre])
        # A border vertex has no curvature of its own: its area counts with the nearest vertex that has one.
        area = np.bincount(owner, self.vertex_area_m2, minlength=count)
        rows, columns, values = [], [], []
        for vertex, (near, fit) in fits.items():
            grid = np.meshgrid(near, near, indexing="ij")
            rows.append(grid[0].ravel())
            columns.append(grid[1].ravel())
            values.append((area[vertex] * fit.T @ (np.array([[1.0], [1.0], [2.0]]) * fit)).ravel())
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return coo_array(entries, (count, count)).tocsr()


def _second_derivatives(offset_m: np.ndarray) -> np.ndarray | None:
    """Least-squares weights (3, n) that give d2/du2, d2/dv2, d2/dudv of values at n offsets; None if undetermined."""
    size = np.abs(offset_m).max()
    u, v = (offset_m / size).T
    basis = np.stack([np.ones_like(u), u, v, u * u / 2, v * v / 2, u * v], axis=1)
    if len(basis) < 6 or np.linalg.cond(basis) > 1e3:
        return None
    return np.linalg.pinv(basis)[3:] / size**2


def plane_stress(material: Material) -> np.ndarray:
    """Stiffness (3, 3) from strain (uu, vv, 2uv) to membrane stress, N/m."""
    nu = material.poisson
    return material.stretch_n_m / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])


def deformation(sheet: Sheet, x: np.ndarray) -> np.ndarray:
    """Derivative of the shape (or of a velocity) over material coordinates, (F, 3, 2)."""
    return np.matmul(x[sheet.faces].transpose(0, 2, 1), sheet.gradients)


def green_strain(F: np.ndarray) -> np.ndarray:
    """Green strain (F, 3) as (uu, vv, 2uv)."""
    fu, fv = F[..., 0], F[..., 1]
    return np.stack([0.5 * ((fu * fu).sum(-1) - 1), 0.5 * ((fv * fv).sum(-1) - 1), (fu * fv).sum(-1)], axis=-1)


def elastic_energy(sheet: Sheet, material: Material, x: np.ndarray) -> float:
    """Stretch and bending energy of the shape `x` (V, 3), J."""
    strain = green_strain(deformation(sheet, x))
    stretch = 0.5 * np.einsum("f,fi,ij,fj->", sheet.face_area_m2, strain, plane_stress(material), strain)
    return float(stretch + 0.5 * material.bending_n_m * (x * (sheet.bending_matrix @ x)).sum())


@dataclass(frozen=True, kw_only=True)
class Swatch:
    """Shape of a square swatch's mesh, diagonals alternating so that no direction is preferred."""

    side_m: float
    vertices_per_side: int

    def sheet(self) -> Sheet:
        """Vertices row by row: vertex j * n + i at (u, v) = (i, j) * spacing."""
        n = self.vertices_per_side
        axis = np.linspace(0.0, self.side_m, n)
        material = np.stack(np.meshgrid(axis, axis, indexing="xy"), axis=-1).reshape(-1, 2)
        faces = []
        for j in range(n - 1):
            for i in range(n - 1):
                a, b, c, d = j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i
                faces += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
        return Sheet(material_m=material, faces=np.array(faces))


def refined(sheet: Sheet) -> tuple[Sheet, np.ndarray]:
    """The sheet with every face cut into four, and the two vertices (W, 2) between which each new vertex lies.

    Vertices of the old sheet keep their numbers, and have themselves twice.
    """
    count = len(sheet.material_m)
    ends = np.sort(sheet.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, index = np.unique(ends, axis=0, return_inverse=True)
    middle = count + index.reshape(-1, 3)
    a, b, c = sheet.faces.T
    ab, bc, ca = middle.T
    faces = np.concatenate([np.stack(part, axis=1) for part in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    own = np.repeat(np.arange(count)[:, None], 2, axis=1)
    between = np.concatenate([own, edges])
    return Sheet(material_m=sheet.material_m[between].mean(1), faces=faces), between


def place_on(sheet: Sheet, point_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Face (n,) and barycentric coordinates (n, 3) of points in material coordinates (n, 2).

    Raises:
        BadInput: a point lies off the sheet by more than 1 % of a face.
    """
    corner = sheet.material_m[sheet.faces]
    _, near = cKDTree(corner.mean(1)).query(point_m, k=min(12, len(sheet.faces)))
    inverse = np.linalg.inv(np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=-1))
    local = np.einsum("nkij,nkj->nki", inverse[near], point_m[:, None] - corner[near, 0])
    weights = np.concatenate([1 - local.sum(-1, keepdims=True), local], axis=-1)
    best = weights.min(-1).argmax(1)
    rows = np.arange(len(point_m))
    chosen = weights[rows, best]
    if (chosen.min(1) < -0.01).any():
        row = int(chosen.min(1).argmin())
        raise BadInput(f"point {row} at {point_m[row]} m lies off the sheet")
    chosen = np.clip(chosen, 0, None)
    return near[rows, best], chosen / chosen.sum(1, keepdims=True)
