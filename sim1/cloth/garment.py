"""The garment as the simulation sees it: triangle mesh with its shape at rest."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.array_file import read_arrays
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class GarmentMesh:
    """A garment's simulation mesh (artifact `garment_mesh`)."""

    vertices_m: np.ndarray  # (v, 3) as scanned, mesh coordinates
    faces: np.ndarray  # (f, 3) int32
    rest_m: np.ndarray  # (v, 3) the shape in which all internal forces vanish


def read_garment_mesh(artifact: Path) -> GarmentMesh:
    """Read `mesh.npz` of a `garment_mesh` artifact.

    Raises:
        BadInput: missing, damaged, indices out of range, or rest shape without area.
    """
    path = artifact / "mesh.npz"
    names = ("vertices_m", "faces", "rest_m")
    arrays = read_arrays(path, names, "garment mesh")
    vertices, faces, rest = (arrays[name] for name in names)
    return checked_mesh(vertices, faces, rest, str(path))


def checked_mesh(vertices: np.ndarray, faces: np.ndarray, rest: np.ndarray, where: str = "mesh") -> GarmentMesh:
    """Build a mesh after checking shapes, finiteness, indices and areas."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or rest.shape != vertices.shape or faces.ndim != 2:
        raise BadInput(
            f"{where}: vertices {vertices.shape}, rest {rest.shape}, faces {faces.shape} do not fit together"
        )
    if not (np.isfinite(vertices).all() and np.isfinite(rest).all()):
        raise BadInput(f"{where}: positions that are not finite; repair the mesh")
    if len(faces) == 0 or faces.min() < 0 or faces.max() >= len(vertices):
        raise BadInput(f"{where}: face indices outside 0..{len(vertices) - 1}")
    smallest = float(face_areas(rest, faces).min())
    if smallest <= 1e-9:
        raise BadInput(f"{where}: the rest shape has a face with an area of {smallest:.2e} m2; remesh without slivers")
    return GarmentMesh(
        vertices_m=np.asarray(vertices, float), faces=np.asarray(faces, np.int32), rest_m=np.asarray(rest, float)
    )


def face_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Areas [m2] of the faces, (f,)."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1)


def unique_edges(faces: np.ndarray) -> np.ndarray:
    """Undirected edges of a triangle mesh, (e, 2), sorted."""
    pairs = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.unique(pairs, axis=0)


def grid_towel(width_m: float, depth_m: float, edge_m: float) -> GarmentMesh:
    """A flat rectangular cloth of nearly equilateral triangles in the plane z = 0, centred at the origin."""
    rows = max(2, round(depth_m / (edge_m * np.sqrt(3.0) / 2.0)) + 1)
    columns = max(2, round(width_m / edge_m) + 1)
    ys = np.linspace(-depth_m / 2, depth_m / 2, rows)
    xs = np.linspace(-width_m / 2, width_m / 2, columns)
    shift = 0.5 * (xs[1] - xs[0])
    points, row_start = [], []
    for row, y in enumerate(ys):
        line = xs if row % 2 == 0 else np.concatenate([xs[:1], xs[:-1] + shift, xs[-1:]])
        row_start.append(sum(len(part) for part in points))
        points.append(np.stack([line, np.full_like(line, y), np.zeros_like(line)], axis=1))
    faces: list[list[int]] = []
    for row in range(rows - 1):
        faces += _strip(points[row][:, 0], points[row + 1][:, 0], row_start[row], row_start[row + 1])
    vertices = np.concatenate(points)
    return checked_mesh(vertices, np.array(faces), vertices.copy(), "grid towel")


def _strip(low: np.ndarray, high: np.ndarray, first_low: int, first_high: int) -> list[list[int]]:
    """Triangles between two rows of points, advancing on the side with the shorter diagonal."""
    i = j = 0
    faces = []
    while i < len(low) - 1 or j < len(high) - 1:
        low_next = abs(low[i + 1] - high[j]) if i < len(low) - 1 else np.inf
        high_next = abs(high[j + 1] - low[i]) if j < len(high) - 1 else np.inf
        if low_next <= high_next:
            faces.append([first_low + i, first_low + i + 1, first_high + j])
            i += 1
        else:
            faces.append([first_low + i, first_high + j + 1, first_high + j])
            j += 1
    return faces
