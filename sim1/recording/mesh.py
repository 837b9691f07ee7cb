"""Rest mesh of a bundle: an OBJ file whose vertex order is the numbering that everything else uses."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class RestMesh:
    """Rest mesh with V vertices and F faces."""

    vertices_m: np.ndarray  # (V, 3)
    faces: np.ndarray  # (F, 3)
    material_m: np.ndarray | None  # (V, 2) along warp and weft; None where the file has no `vt`


def read_mesh(path: Path) -> RestMesh:
    """Read and check the rest mesh.

    Raises:
        BadInput: missing, not triangles, an index out of range, millimetres, a seam in the material coordinates.
    """
    vertices, texture, faces, corners = [], [], [], []
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path}: not readable ({error}); a bundle needs its rest mesh as OBJ") from error
    for row, line in enumerate(lines, start=1):
        words = line.split("#")[0].split()
        try:
            if not words:
                continue
            if words[0] == "v":
                vertices.append([float(word) for word in words[1:4]])
            elif words[0] == "vt":
                texture.append([float(word) for word in words[1:3]])
            elif words[0] == "f":
                if len(words) != 4:
                    raise BadInput(f"{path}:{row}: a face of {len(words) - 1} corners; triangulate the mesh")
                parts = [word.split("/") for word in words[1:]]
                faces.append([int(part[0]) - 1 for part in parts])
                corners.append([int(part[1]) - 1 if len(part) > 1 and part[1] else -1 for part in parts])
        except ValueError as error:
            if isinstance(error, BadInput):
                raise
            raise BadInput(f"{path}:{row}: {line.strip()!r} is not readable ({error})") from error
    return _checked(path, vertices, texture, faces, corners)


def _checked(path: Path, vertices: list, texture: list, faces: list, corners: list) -> RestMesh:
    if len(vertices) < 3 or not faces or {len(row) for row in vertices} != {3}:
        raise BadInput(f"{path}: {len(vertices)} vertices and {len(faces)} faces; expected a triangle mesh")
    points, triangles = np.array(vertices), np.array(faces)
    if not np.isfinite(points).all():
        raise BadInput(f"{path}: vertex {int(np.argmin(np.isfinite(points).all(1)))} is not finite")
    if triangles.min() < 0 or triangles.max() >= len(points):
        face = int(np.argmax(((triangles < 0) | (triangles >= len(points))).any(1)))
        raise BadInput(f"{path}: face {face} names vertex {triangles[face].max() + 1} of {len(points)}")
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    if not 0.02 < size < 5.0:
        raise BadInput(
            f"{path}: the mesh measures {size:.3g} m across; a garment has 0.02 to 5 m: are these millimetres or inches?"
        )
    return RestMesh(vertices_m=points, faces=triangles, material_m=_material(path, points, triangles, texture, corners))


def _material(path: Path, points: np.ndarray, faces: np.ndarray, texture: list, corners: list) -> np.ndarray | None:
    if not texture:
        return None
    coordinates, index = np.array(texture), np.array(corners)
    if index.min() < 0 or index.max() >= len(coordinates):
        raise BadInput(f"{path}: a face names material coordinate {index.max() + 1} of {len(coordinates)} or none")
    material = np.full((len(points), 2), np.nan)
    material[faces.ravel()] = coordinates[index.ravel()]
    if not np.array_equal(material[faces.ravel()], coordinates[index.ravel()]):
        vertex = int(faces.ravel()[np.argmax((material[faces.ravel()] != coordinates[index.ravel()]).any(1))])
        raise BadInput(f"{path}: vertex {vertex} has two material coordinates; give one `vt` per vertex")
    used = np.unique(faces)
    if len(used) < len(points):
        raise BadInput(
            f"{path}: vertex {int(np.setdiff1d(np.arange(len(points)), used)[0])} belongs to no face; remove it"
        )
    ends = faces[:, [0, 1]]
    flat = np.linalg.norm(material[ends[:, 0]] - material[ends[:, 1]], axis=1)
    long = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    ratio = float(np.median(flat / np.maximum(long, 1e-12)))
    if not 0.5 < ratio < 2.0:
        raise BadInput(
            f"{path}: edges in `vt` are {ratio:.3g} times as long as the mesh's; material coordinates are in metres"
        )
    return material


def write_mesh(path: Path, mesh: RestMesh) -> None:
    """Write a rest mesh as OBJ; `vt` where material coordinates are known."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices_m]
    if mesh.material_m is not None:
        lines += [f"vt {u:.9g} {v:.9g}" for u, v in mesh.material_m]
        lines += ["f " + " ".join(f"{k + 1}/{k + 1}" for k in face) for face in mesh.faces]
    else:
        lines += ["f " + " ".join(str(k + 1) for k in face) for face in mesh.faces]
    path.write_text("\n".join(lines) + "\n")
