"""The scene as one self-contained USD file, for any viewer."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom, Vt

from sim1.scene.description import Camera, Scene
from sim1.scene.parts import Part

ROOT = "/scene"
FOCAL_MM = 24.0  # any: only its ratio to the aperture is seen


def write_usd(path: Path, scene: Scene, parts: Sequence[Part]) -> None:
    """Write table, arms, garment and cameras to `path` (`.usda`): metres, z up, no reference to another file."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, ROOT).GetPrim())
    for part in parts:
        frame = UsdGeom.Xform.Define(stage, f"{ROOT}/{part.path}")
        frame.AddTransformOp().Set(_matrix(part.pose))
        for index, (vertices, faces, rgb) in enumerate(part.meshes):
            _mesh(stage, f"{ROOT}/{part.path}/mesh{index}", vertices, faces, rgb)
    for name, camera in scene.cameras.items():
        _camera(stage, f"{ROOT}/cameras/{name}", camera)
    for arm, camera in scene.wrist_cameras.items():
        _camera(stage, f"{ROOT}/arms/{arm}/{camera.link}/camera", camera)
    stage.GetRootLayer().Export(str(path))


def garment_points(path: Path) -> np.ndarray:
    """Garment vertices (v, 3) in the world, as the USD file places them.

    Raises:
        LookupError: the file holds no garment mesh.
    """
    stage = Usd.Stage.Open(str(path))
    mesh = UsdGeom.Mesh.Get(stage, f"{ROOT}/garment/mesh0")
    if not mesh:
        raise LookupError(f"{path.name}: no mesh at {ROOT}/garment/mesh0")
    matrix = np.array(UsdGeom.XformCache().GetLocalToWorldTransform(mesh.GetPrim()))
    return np.array(mesh.GetPointsAttr().Get(), float) @ matrix[:3, :3] + matrix[3, :3]


def _matrix(pose: np.ndarray) -> Gf.Matrix4d:
    return Gf.Matrix4d(pose.T.tolist())  # USD multiplies row vectors from the left


def _mesh(stage: Usd.Stage, path: str, vertices: np.ndarray, faces: np.ndarray, rgb: np.ndarray) -> None:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(vertices, np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces, np.int32).ravel()))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(
        Vt.Vec3fArray.FromNumpy(np.stack([vertices.min(axis=0), vertices.max(axis=0)]).astype(np.float32))
    )
    mesh.CreateDoubleSidedAttr(True)
    colors = np.atleast_2d(rgb).astype(np.float32)
    variability = UsdGeom.Tokens.constant if len(colors) == 1 else UsdGeom.Tokens.uniform
    mesh.CreateDisplayColorPrimvar(variability).Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(colors)))


def _camera(stage: Usd.Stage, path: str, camera: Camera) -> None:
    prim = UsdGeom.Camera.Define(stage, path)
    prim.CreateFocalLengthAttr(FOCAL_MM)
    prim.CreateVerticalApertureAttr(FOCAL_MM * camera.height / camera.fy_px)
    prim.CreateHorizontalApertureAttr(FOCAL_MM * camera.width / camera.fy_px)
    prim.CreateClippingRangeAttr(Gf.Vec2f(0.01, 20.0))
    prim.AddTransformOp().Set(_matrix(camera.pose))
