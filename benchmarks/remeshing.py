"""Isotropic remeshing of a dense surface: decimated first, as `sim1.scan.remesh` does it, against straight away."""

from typing import Any

import numpy as np

from benchmarks.timing import against
from sim1.scan.cloud import Shape
from sim1.scan.remesh import remesh

EDGE_M = 0.02


def compare() -> dict[str, Any]:
    """A wavy sheet of 0.4 m with 2 mm triangles to 20 mm triangles."""
    import pymeshlab

    sheet = _wavy_sheet(side_m=0.4, cell_m=0.002)

    def straight_away() -> None:
        meshes = pymeshlab.MeshSet(verbose=False)
        meshes.add_mesh(pymeshlab.Mesh(sheet.vertices_m, sheet.faces))
        meshes.meshing_isotropic_explicit_remeshing(
            iterations=10, targetlen=pymeshlab.PureValue(EDGE_M), featuredeg=180.0
        )

    return against(
        f"remeshing {len(sheet.faces)} triangles, decimated first",
        lambda: remesh(sheet, EDGE_M),
        "the same straight away",
        straight_away,
    )


def _wavy_sheet(side_m: float, cell_m: float) -> Shape:
    count = round(side_m / cell_m) + 1
    x, y = np.meshgrid(np.linspace(0, side_m, count), np.linspace(0, side_m, count))
    vertices = np.stack([x, y, 0.01 * np.sin(20 * x) * np.cos(15 * y)], axis=-1).reshape(-1, 3)
    a = np.arange(count * count).reshape(count, count)
    a, b, c, d = a[:-1, :-1].ravel(), a[:-1, 1:].ravel(), a[1:, :-1].ravel(), a[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([b, d, c], axis=1)]).astype(np.int32)
    return Shape(vertices_m=vertices, faces=faces)
