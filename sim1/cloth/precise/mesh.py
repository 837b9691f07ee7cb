"""A flat rest mesh, its curvature stencils, its refinement, and points on it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra, reverse_cuthill_mckee
from scipy.spatial import cKDTree

from sim1.stage import BadInput

THINNEST_M2 = 1e-10  # a face of less has no area
FEW = range(9, 17)  # nearest vertices that a stencil takes in where faces around it are too few
END = 0.01  # of the length of the cloth: what lies at its end
CENTRINGS = 100  # rounds of bringing neighbours nearer in the order of vertices


@dataclass(frozen=True, kw_only=True)
class Stencils:
    """Weights that give second and first derivatives of the shape over the material, C stencils of n nodes in all."""

    first: np.ndarray  # (C + 1,) where the nodes of each start
    node: np.ndarray  # (n,)
    second: np.ndarray  # (n, 3) of d2/du2, d2/dv2, d2/dudv [1/m^2]
    slope: np.ndarray  # (n, 2) of d/du, d/dv [1/m]
    ripple: (
        np.ndarray
    )  # (n, R) of the patterns that no quadratic follows, over the squared size [1/m^2]; unused columns zero
    centre: np.ndarray  # (C,) vertex in the middle
    area_m2: np.ndarray  # (C,) whose bending each stands for


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A flat rest mesh: V vertices, F faces."""

    material_m: np.ndarray  # (V, 2) material coordinates, u along the warp
    faces: np.ndarray  # (F, 3)
    source: str = "rest mesh"  # the file that it is of, for messages

    @cached_property
    def face_area_m2(self) -> np.ndarray:
        """Rest area of each face, (F,).

        Raises:
            BadInput: a face without area, or one that lies the other way up than most.
        """
        a, b, c = (self.material_m[self.faces[:, k]] for k in range(3))
        area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        if (thin := np.abs(area) < THINNEST_M2).any():
            face = int(np.argmax(thin))
            raise BadInput(
                f"{self.source}: face {face} has no area in `vt` ({area[face]:.1e} m^2; {thin.sum()} such faces of {len(area)}); "
                "give each vertex its own place on the cloth, or remesh"
            )
        if (turned := np.sign(area) != np.sign(np.median(np.sign(area)))).any():
            face = int(np.argmax(turned))
            raise BadInput(
                f"{self.source}: face {face} lies the other way up in `vt` than most ({turned.sum()} such faces of {len(area)}): the cloth "
                "would overlap itself; lay it out flat, or turn the corners of those faces round"
            )
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
    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Edges (E, 2) and how many faces use each, (E,)."""
        ends = np.sort(np.concatenate([self.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
        return np.unique(ends, axis=0, return_counts=True)

    @cached_property
    def stars(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Faces around each vertex: first (V + 1,), face (3F,), corners' places in the ring (3F, 3); rings: first (V + 1,), node."""
        around: list[list[int]] = [[] for _ in range(len(self.material_m))]
        for f, face in enumerate(self.faces):
            for vertex in face:
                around[vertex].append(f)
        rings = [np.unique(self.faces[faces]) for faces in around]
        local = [np.searchsorted(ring, self.faces[faces]) for ring, faces in zip(rings, around, strict=True)]
        return (
            np.concatenate([[0], np.cumsum([len(faces) for faces in around])]),
            np.concatenate([np.array(faces) for faces in around]),
            np.concatenate(local),
            np.concatenate([[0], np.cumsum([len(ring) for ring in rings])]),
            np.concatenate(rings),
        )

    @cached_property
    def stencils(self) -> Stencils:
        """A stencil around every inner vertex; a border vertex' area counts with the nearest of them.

        Raises:
            BadInput: a mesh too small to bend.
        """
        count = len(self.material_m)
        edges, uses = self.edges
        inner = np.setdiff1d(np.unique(self.faces), edges[uses == 1])
        if len(inner) == 0:
            raise BadInput(f"{self.source}: none of its {count} vertices lies inside; give a mesh of 4 x 4 or more")
        tree = cKDTree(self.material_m)
        neighbours: list[list[int]] = [[] for _ in range(count)]
        for a, b in edges:
            neighbours[a].append(b)
            neighbours[b].append(a)
        fits = {}
        for vertex in inner:
            for near in self._wider_and_wider(int(vertex), neighbours[vertex], tree):
                fit = _derivatives(self.material_m[near] - self.material_m[vertex])
                if fit is not None:
                    fits[int(vertex)] = near, fit
                    break
        if not fits:
            raise BadInput(
                f"{self.source}: none of its {count} vertices has enough neighbours to bend; give a mesh of 4 x 4 or more"
            )
        centres = np.array(list(fits))
        owner = centres[cKDTree(self.material_m[centres]).query(self.material_m)[1]]
        for vertex in np.setdiff1d(np.arange(count), np.concatenate([near for near, _ in fits.values()])):
            centre = int(owner[vertex])  # a corner that no inner vertex touches would flap for free
            near = np.union1d(fits[centre][0], [vertex])
            fits[centre] = near, _derivatives(self.material_m[near] - self.material_m[centre])
        area = np.bincount(owner, self.vertex_area_m2, minlength=count)
        ripples = [_ripples(self.material_m[near] - self.material_m[vertex]) for vertex, (near, _) in fits.items()]
        most = max(pattern.shape[1] for pattern in ripples)
        return Stencils(
            first=np.concatenate([[0], np.cumsum([len(near) for near, _ in fits.values()])]),
            node=np.concatenate([near for near, _ in fits.values()]),
            second=np.concatenate([fit[2:].T for _, fit in fits.values()]),
            slope=np.concatenate([fit[:2].T for _, fit in fits.values()]),
            ripple=np.concatenate([np.pad(one, ((0, 0), (0, most - one.shape[1]))) for one in ripples]),
            centre=centres,
            area_m2=area[centres],
        )

    def _wider_and_wider(self, vertex: int, neighbours: list[int], tree: cKDTree) -> Iterator[np.ndarray]:
        """Nodes (n,) for a stencil: the ring around a vertex, what lies behind the ring's edges as well, and ever more of the nearest."""
        ring = np.array(sorted([vertex, *neighbours]))
        yield ring
        behind = np.unique(self.faces[np.isin(self.faces, ring).sum(1) > 1])
        yield behind
        for few in FEW:
            yield np.union1d(behind, tree.query(self.material_m[vertex], k=min(few, len(self.material_m)))[1])


def _derivatives(offset_m: np.ndarray) -> np.ndarray | None:
    """Least-squares weights (5, n) of d/du, d/dv, d2/du2, d2/dv2, d2/dudv at n offsets; None if undetermined."""
    basis, size = _quadratics(offset_m)
    if len(basis) < 6 or np.linalg.cond(basis) > 1e3:
        return None
    return np.linalg.pinv(basis)[1:] / np.array([size, size, size**2, size**2, size**2])[:, None]


def square_sheet(count: int, side_m: float) -> Sheet:
    """A square of count x count vertices, diagonals alternating; vertex j * count + i lies at (u, v) = (i, j) * spacing."""
    axis = np.linspace(0.0, side_m, count)
    faces = []
    for j in range(count - 1):
        for i in range(count - 1):
            a, b, c, d = j * count + i, j * count + i + 1, (j + 1) * count + i + 1, (j + 1) * count + i
            faces += [(a, b, c), (a, c, d)] if (i + j) % 2 == 0 else [(a, b, d), (b, c, d)]
    return Sheet(material_m=np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2), faces=np.array(faces))


def _ripples(offset_m: np.ndarray) -> np.ndarray:
    """Orthonormal patterns (n, n - 6) that are in no quadratic over n offsets, over the mean squared distance of the neighbours."""
    basis, _ = _quadratics(offset_m)
    patterns = np.linalg.svd(basis)[0][:, 6:]
    return patterns * (len(offset_m) - 1) / np.square(offset_m).sum()


def _quadratics(offset_m: np.ndarray) -> tuple[np.ndarray, float]:
    """The six quadratics (n, 6) over n offsets in units of the largest, and that."""
    size = float(np.abs(offset_m).max())
    u, v = (offset_m / size).T
    return np.stack([np.ones_like(u), u, v, u * u / 2, v * v / 2, u * v], axis=1), size


def narrow(sheet: Sheet) -> np.ndarray:
    """An order (V,) of the vertices in which neighbours lie close together.

    The best of the mesh's own, Cuthill and McKee's (1969), fronts that spread from an end of the cloth face by face, and what each becomes as
    every vertex moves again and again to the middle of the first and the last that it is coupled with (after the node centroids of Lim,
    Rodrigues and Xiao 2006).
    """
    count = len(sheet.material_m)
    stencils = sheet.stencils
    row = np.repeat(np.arange(len(stencils.centre)), np.diff(stencils.first))
    touch = coo_array((np.ones(len(row)), (row, stencils.node)), (len(stencils.centre), count)).tocsr()
    corner = np.repeat(np.arange(len(sheet.faces)), 3)
    face = coo_array((np.ones(len(corner)), (corner, sheet.faces.ravel())), (len(sheet.faces), count)).tocsr()
    near = (face.T @ face).tocsr()  # vertices that share a face
    coupled = (touch.T @ touch + near @ near).tocsr()
    entries = coupled.tocoo()
    best, least = np.arange(count), count
    for order in (best, reverse_cuthill_mckee(coupled, True), *_fronts(sheet.material_m, near)):
        for _ in range(CENTRINGS):
            place = np.empty(count, int)
            place[order] = np.arange(count)
            width = int(np.abs(place[entries.row] - place[entries.col]).max())
            if width < least:
                best, least = order, width
            ends = place[coupled.indices]
            last, first = (end.reduceat(ends, coupled.indptr[:-1]) for end in (np.maximum, np.minimum))
            order = np.lexsort((place, first + last))
    return best


def _fronts(material_m: np.ndarray, near: csr_array) -> Iterator[np.ndarray]:
    """Orders (V,) by how many faces away the nearest of the vertices at an end of the cloth is, each end in turn; side by side within."""
    for axis in range(2):
        for along in (material_m[:, axis], -material_m[:, axis]):
            end = np.flatnonzero(along <= along.min() + END * np.ptp(along))
            away = dijkstra(near, indices=end, min_only=True, unweighted=True)
            yield np.lexsort((material_m[:, 1 - axis], away))


def reordered(sheet: Sheet, order: np.ndarray) -> tuple[Sheet, np.ndarray]:
    """The sheet with vertices in another order, and the new number (V,) of each old vertex."""
    place = np.empty(len(order), int)
    place[order] = np.arange(len(order))
    return replace(sheet, material_m=sheet.material_m[order], faces=place[sheet.faces]), place


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
    between = np.concatenate([np.repeat(np.arange(count)[:, None], 2, axis=1), edges])
    return replace(sheet, material_m=sheet.material_m[between].mean(1), faces=faces), between


def place_on(sheet: Sheet, point_m: np.ndarray, names: Sequence[str] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Face (n,) and barycentric coordinates (n, 3) of points in material coordinates (n, 2).

    `names`, one for each point, begin the message of an error.

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
        raise BadInput(
            f"{names[row] if names else f'point {row}'} at {point_m[row].tolist()} m of the cloth lies off the sheet; correct its face "
            "and weights, or remesh: faces beside each other may not differ much in size"
        )
    chosen = np.clip(chosen, 0, None)
    return near[rows, best], chosen / chosen.sum(1, keepdims=True)
