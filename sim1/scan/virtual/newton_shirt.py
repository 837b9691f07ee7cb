"""The shirt mesh of the newton package, in metres and in the project's axes."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np

from sim1.scan.cloud import Shape


def newton_shirt() -> Shape:
    """`unisex_shirt.usd` of the installed newton package, subdivided once (Loop): 25 667 vertices, front towards x."""
    import trimesh
    from pxr import Usd, UsdGeom

    spec = find_spec("newton")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("the shirt's shape comes from the newton package, which is not installed")
    stage = Usd.Stage.Open(str(Path(spec.origin).parent / "examples" / "assets" / "unisex_shirt.usd"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/root/shirt"))
    points = np.array(mesh.GetPointsAttr().Get(), float) * UsdGeom.GetStageMetersPerUnit(stage)
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    # The file is y up with the front towards z: (x, y, z) becomes (left, up, front).
    vertices, faces = trimesh.remesh.subdivide_loop(points[:, [2, 0, 1]], faces, 1)
    return Shape(vertices_m=vertices, faces=faces.astype(np.int32))
