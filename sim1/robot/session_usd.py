"""A session as USD: the garment's vertices and the arms' links over time, for any USD viewer."""

from pathlib import Path

import numpy as np

from sim1.episode import ARMS, RATE_HZ, Episode
from sim1.robot.gripper import travel_from_openness
from sim1.robot.kinematics import Arm
from sim1.robot.urdf import Shape
from sim1.scene.description import Scene


def write_session_usd(path: Path, episode: Episode, faces: np.ndarray, scene: Scene, *, every: int = 2) -> None:
    """Write every `every`-th frame; time codes are frames at 30 Hz, metres, z up."""
    from pxr import Gf, Sdf, Usd, UsdGeom, Vt

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(RATE_HZ)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(episode.frame_count - 1)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/session").GetPrim())

    table = UsdGeom.Cube.Define(stage, "/session/table")
    size = scene.table_size_m
    table.AddTranslateOp().Set(Gf.Vec3d(0, 0, float(scene.table_top_m - size[2] / 2)))
    table.AddScaleOp().Set(Gf.Vec3f(*(float(edge) / 2 for edge in size)))

    garment = UsdGeom.Mesh.Define(stage, "/session/garment")
    garment.CreateFaceVertexCountsAttr(Vt.IntArray([3] * len(faces)))
    garment.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces, np.int32).reshape(-1)))
    garment.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    garment.CreateDoubleSidedAttr(True)
    garment.CreateDisplayColorAttr([Gf.Vec3f(0.27, 0.47, 0.75)])
    points = garment.CreatePointsAttr()
    frames = range(0, episode.frame_count, every)
    for frame in frames:
        points.Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(episode.garment_m[frame], np.float32)), frame)

    arm = Arm.from_urdf(scene.urdf)
    for side, name in enumerate(ARMS):
        poses = {
            frame: arm.link_poses(
                episode.joints_rad[frame, side], float(travel_from_openness(episode.openness[frame, side]))
            )
            for frame in frames
        }
        UsdGeom.Xform.Define(stage, f"/session/{name}")
        for link in arm.robot.links.values():
            prim = UsdGeom.Xform.Define(stage, f"/session/{name}/{link.name}")
            motion = prim.AddTransformOp()
            for frame in frames:
                motion.Set(_matrix(scene.base_to_world[name] @ poses[frame][link.name]), frame)
            for index, shape in enumerate(link.visuals):
                _add_shape(stage, Sdf.Path(f"/session/{name}/{link.name}/visual{index}"), shape)
    stage.GetRootLayer().Save()


def _add_shape(stage: "object", path: "object", shape: Shape) -> None:
    from pxr import Gf, UsdGeom

    if shape.kind == "box":
        solid = UsdGeom.Cube.Define(stage, path)
        solid.CreateSizeAttr(1.0)
        scale = shape.size_m
    elif shape.kind == "cylinder":
        solid = UsdGeom.Cylinder.Define(stage, path)
        solid.CreateRadiusAttr(shape.size_m[0])
        solid.CreateHeightAttr(shape.size_m[1])
        scale = (1.0, 1.0, 1.0)
    else:
        solid = UsdGeom.Sphere.Define(stage, path)
        solid.CreateRadiusAttr(shape.size_m[0])
        scale = (1.0, 1.0, 1.0)
    solid.AddTransformOp().Set(_matrix(shape.origin))
    solid.AddScaleOp().Set(Gf.Vec3f(*map(float, scale)))
    solid.CreateDisplayColorAttr([Gf.Vec3f(*map(float, shape.rgba[:3]))])


def _matrix(pose: np.ndarray) -> "object":
    """USD's row-vector matrix of a pose (4, 4)."""
    from pxr import Gf

    return Gf.Matrix4d(*np.asarray(pose, float).T.reshape(-1).tolist())
