"""Strict reader of Wavefront OBJ geometry: vertices with optional colours, normals, polygons."""

from itertools import pairwise
from pathlib import Path

import numpy as np

from sim1.stage import BadInput


def read_obj(path: Path) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Vertex properties by name (x, y, z, and red, green, blue 0..255 where `v` lines carry colours), triangles (f, 3) int32.

    Normals (`vn`) are taken where there are as many as vertices. Materials and texture coordinates are skipped.

    Raises:
        BadInput: no vertices, or a line that is not valid OBJ.
    """
    vertices: list[list[float]] = []
    normals: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        words = line.split("#")[0].split()
        try:
            match words[:1]:
                case ["v"]:
                    vertices.append([float(word) for word in words[1:]])
                    if len(words) not in (4, 5, 7, 8):
                        raise ValueError(f"{len(words) - 1} numbers")
                case ["vn"]:
                    normals.append([float(word) for word in words[1:4]])
                case ["f"]:
                    corners = [_vertex(word, len(vertices)) for word in words[1:]]
                    faces += [(corners[0], a, b) for a, b in pairwise(corners[1:])]
        except ValueError as error:
            raise BadInput(
                f"{path}: line {number}, {line.strip()[:60]!r}: not valid OBJ ({error}); export it again"
            ) from error
    if not vertices:
        raise BadInput(f"{path}: no vertices ('v' lines); is this an OBJ point cloud or mesh?")
    columns = min(len(row) for row in vertices)
    table = np.array([row[:columns] for row in vertices])
    vertex = {name: table[:, k] for k, name in enumerate("xyz")}
    if columns >= 6:
        scale = 255.0 if np.nanmax(table[:, 3:6]) <= 1.0 else 1.0
        for k, name in enumerate(("red", "green", "blue")):
            vertex[name] = np.clip(np.round(table[:, 3 + k] * scale), 0, 255).astype(np.uint8)
    if len(normals) == len(vertices):
        for k, name in enumerate(("nx", "ny", "nz")):
            vertex[name] = np.array(normals)[:, k]
    triangles = np.array(faces, np.int32).reshape(-1, 3)
    if len(triangles) and triangles.max() >= len(vertices):
        raise BadInput(
            f"{path}: a face names vertex {triangles.max() + 1} of {len(vertices)}; the file is truncated, export it again"
        )
    return vertex, triangles


def _vertex(word: str, count: int) -> int:
    index = int(word.split("/")[0])
    if index == 0 or index < -count:
        raise ValueError(f"vertex index {index}, with {count} vertices so far")
    return index - 1 if index > 0 else count + index
