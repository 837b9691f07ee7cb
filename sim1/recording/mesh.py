"""Rest mesh of a bundle: an OBJ file whose vertex order is the numbering that everything else uses."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from sim1.recording.problems import Several
from sim1.stage import BadInput

SAME_PLACE_M = 1e-7  # two vertices this close are one, written twice
THINNEST = 1e-3  # height of a face over its longest edge: thinner ones have no usable gradient
LARGEST = 1e6  # of a number in the file, in any unit that people use
OFF_SHEET_M = 0.002  # a marker measured with a ruler may come out this far beyond the hem


@dataclass(frozen=True, kw_only=True)
class RestMesh:
    """Rest mesh with V vertices and F faces."""

    vertices_m: np.ndarray  # (V, 3)
    faces: np.ndarray  # (F, 3)
    material_m: np.ndarray | None  # (V, 2) along warp and weft; None where the file has no `vt`
    path: Path = Path("garment.obj")  # where it was read from, for messages


def read_mesh(path: Path, metres: float = 1.0, named: Path | None = None) -> RestMesh:
    """Read and check the rest mesh; the file's numbers times `metres` are metres. `named` is the file that it was imported from.

    Raises:
        BadInput: missing, not triangles, an index out of range, another unit, a seam in the material coordinates, a face
            without area, a vertex twice or in no face.
    """
    vertices, texture, faces, corners = [], [], [], []
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(
            f"{path}: not readable ({error}); a bundle needs its rest mesh as OBJ, under the name in bundle.yaml (garment.mesh)"
        ) from error
    for row, line in enumerate(lines, start=1):
        words = line.split("#")[0].split()
        try:
            if not words:
                continue
            if words[0] == "v":
                vertices.append(_numbers(words[1:4], 3))
            elif words[0] == "vt":
                texture.append(_numbers(words[1:3], 2))
            elif words[0] == "f":
                if len(words) != 4:
                    raise BadInput(f"{path}:{row}: a face of {len(words) - 1} corners; triangulate the mesh")
                parts = [word.split("/") for word in words[1:]]
                faces.append([_index(part[0]) for part in parts])
                corners.append([_index(part[1]) if len(part) > 1 and part[1] else -1 for part in parts])
        except BadInput:
            raise
        except ValueError as error:
            raise BadInput(f"{path}:{row}: {line.strip()[:80]!r} is not readable ({error})") from error
    if len(vertices) < 3 or not faces:
        raise BadInput(f"{path}: {len(vertices)} vertices and {len(faces)} faces; expected a triangle mesh")
    path = named or path  # both have the same vertices and faces, if not the same lines
    points, triangles = np.array(vertices) * metres, np.array(faces)
    if triangles.max() >= len(points):
        face = int(np.argmax((triangles >= len(points)).any(1)))
        raise BadInput(f"{path}: face {face} names vertex {triangles[face].max() + 1} of {len(points)}")
    if wrong := list(_wrong_shape(path, points, triangles)):
        raise Several(wrong)
    material = _material(path, len(points), triangles, np.array(texture) * metres, np.array(corners))
    if material is not None and (wrong := list(_wrong_material(path, points, triangles, material))):
        raise Several(wrong)
    return RestMesh(vertices_m=points, faces=triangles, material_m=material, path=path)


def _numbers(words: list[str], count: int) -> list[float]:
    if len(words) < count:
        raise ValueError(f"{len(words)} numbers, expected {count}")
    values = [float(word) for word in words]
    if not all(abs(value) < LARGEST for value in values):
        raise ValueError(f"a number is not finite, or beyond {LARGEST:g}")
    return values


def _index(word: str) -> int:
    number = int(word)
    if not 1 <= number < 2**31:
        raise ValueError(f"index {number}; this format counts vertices from 1, relative numbers are not supported")
    return number - 1


def _wrong_shape(path: Path, points: np.ndarray, faces: np.ndarray) -> Iterator[str]:
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if not 0.02 < size < 5.0:
        yield f"{path}: the mesh measures {size:.3g} m across; a garment has 0.02 to 5 m: are these millimetres or inches?"
    twice = cKDTree(points).query_pairs(SAME_PLACE_M * min(size, 1.0), output_type="ndarray")
    if len(twice):
        a, b = (int(vertex) for vertex in twice[0])
        yield (
            f"{path}: vertices {a} and {b} are at the same place {points[a].tolist()} ({len(twice)} such pairs); "
            "merge them: the cloth would come apart there"
        )
    if len(alone := np.setdiff1d(np.arange(len(points)), faces)):
        yield f"{path}: vertex {alone[0]} belongs to no face ({len(alone)} such vertices); remove it"
    if (flat := _thinness(points[faces]) < THINNEST).any():
        face = int(np.argmax(flat))
        yield f"{path}: face {face} of vertices {faces[face].tolist()} has no area ({int(flat.sum())} such faces); remesh"
    ordered = np.sort(faces, axis=1)
    _, first, count = np.unique(ordered, axis=0, return_index=True, return_counts=True)
    if (count > 1).any():
        face = int(first[np.argmax(count > 1)])
        yield f"{path}: face {face} of vertices {faces[face].tolist()} occurs twice; its cloth would weigh twice as much"


def _thinness(corner: np.ndarray) -> np.ndarray:
    """Height over longest edge of triangles (F, 3, 2 or 3), (F,); 0 where all corners are on a line."""
    corner = np.pad(corner, ((0, 0), (0, 0), (0, 3 - corner.shape[2])))
    longest = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(1)
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return area / np.maximum(longest, 1e-30) ** 2


def _material(path: Path, count: int, faces: np.ndarray, texture: np.ndarray, index: np.ndarray) -> np.ndarray | None:
    if not len(texture):
        return None
    if index.min() < 0:
        raise BadInput(f"{path}: face {int(np.argmax((index < 0).any(1)))} has no `vt`; give every corner one, or none")
    if index.max() >= len(texture):
        raise BadInput(f"{path}: a face names material coordinate {index.max() + 1} of {len(texture)}")
    material = np.full((count, 2), np.nan)
    material[faces.ravel()] = texture[index.ravel()]
    if (other := (material[faces.ravel()] != texture[index.ravel()]).any(1)).any():
        vertex = int(faces.ravel()[np.argmax(other)])
        raise BadInput(f"{path}: vertex {vertex} has two material coordinates; give one `vt` per vertex")
    return material


def _wrong_material(path: Path, points: np.ndarray, faces: np.ndarray, material: np.ndarray) -> Iterator[str]:
    ends = faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    flat = np.linalg.norm(material[ends[:, 0]] - material[ends[:, 1]], axis=1)
    long = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    low, ratio, high = np.percentile(flat / np.maximum(long, 1e-12), [5, 50, 95])
    if not (0.8 < ratio < 1.25 and low > 0.5 and high < 2.0):
        yield (
            f"{path}: edges in `vt` are {ratio:.3g} times as long as the mesh's ({low:.3g} to {high:.3g} for most); "
            "material coordinates are in metres like the vertices, not a texture from 0 to 1"
        )
    elif (thin := _thinness(material[faces]) < THINNEST).any():
        face = int(np.argmax(thin))
        yield f"{path}: face {face} has no area in `vt` ({int(thin.sum())} such faces); give each vertex its own place on the cloth"


def place_on_mesh(mesh: RestMesh, point_m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where points in material coordinates (n, 2) are: face (n,), barycentric weights (n, 3), distance off the sheet (n,).

    A point beyond the hem is moved onto it; whether it was too far is for the caller to say (`OFF_SHEET_M`).

    Raises:
        BadInput: the mesh has no material coordinates.
    """
    if mesh.material_m is None:
        raise BadInput("garment mesh: no `vt`; material coordinates of markers need those of the mesh, in metres")
    corner = mesh.material_m[mesh.faces]
    inverse = np.linalg.inv(np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=-1))
    face, weight, off = [], [], []
    for point in point_m:
        weights = _nearest_weights(corner, inverse, point)
        away = np.linalg.norm((corner * weights[..., None]).sum(1) - point, axis=1)
        face.append(int(away.argmin()))
        weight.append(weights[face[-1]])
        off.append(float(away.min()))
    return np.array(face, int), np.array(weight).reshape(-1, 3), np.array(off)


def _nearest_weights(corner: np.ndarray, inverse: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Barycentric weights (F, 3) of the place in each triangle (F, 3, 2) that is nearest to a point (2,)."""
    local = np.einsum("fij,fj->fi", inverse, point - corner[:, 0])
    inside = np.column_stack([1 - local.sum(1), local])
    best, least = np.clip(inside, 0, None), np.where((inside >= 0).all(1), 0.0, np.inf)
    for a, b in ((0, 1), (1, 2), (2, 0)):
        edge = corner[:, b] - corner[:, a]
        along = np.clip(((point - corner[:, a]) * edge).sum(1) / (edge**2).sum(1), 0, 1)
        away = np.linalg.norm(corner[:, a] + along[:, None] * edge - point, axis=1)
        on_edge = np.zeros_like(inside)
        on_edge[:, a], on_edge[:, b] = 1 - along, along
        best, least = np.where((away < least)[:, None], on_edge, best), np.minimum(away, least)
    return best


def write_mesh(path: Path, mesh: RestMesh) -> None:
    """Write a rest mesh as OBJ; `vt` where material coordinates are known."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices_m]
    if mesh.material_m is not None:
        lines += [f"vt {u:.9g} {v:.9g}" for u, v in mesh.material_m]
        lines += ["f " + " ".join(f"{k + 1}/{k + 1}" for k in face) for face in mesh.faces]
    else:
        lines += ["f " + " ".join(str(k + 1) for k in face) for face in mesh.faces]
    path.write_text("\n".join(lines) + "\n")
