"""From a person's files to a checked `Scene` in an artifact folder."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import trimesh

from sim1.episode import ARMS
from sim1.robot.calibration import ArmsFile, Placement, place_arms, read_arms
from sim1.robot.kinematics import Arm
from sim1.robot.planar import PlanarArm
from sim1.scene.description import Scene, write_scene
from sim1.scene.environment import read_cameras, read_table
from sim1.scene.garment import read_garment
from sim1.scene.placement import lying_pose
from sim1.stage import BadInput


class Choice(Protocol):
    """What of the stage's configuration matters here."""

    table: str
    gap_m: float


@dataclass(frozen=True, kw_only=True)
class Assembled:
    """A scene with what it was made of."""

    scene: Scene
    arm: Arm
    planar: PlanarArm
    arms: ArmsFile
    placement: Placement
    table: trimesh.Trimesh
    table_tolerance_m: float
    garment_m: np.ndarray  # (v, 3) mesh coordinates
    garment_faces: np.ndarray  # (f, 3)
    garment_rgb: np.ndarray  # (f, 3)


def assemble(garment_mesh: Path, robot: Path, environment: Path, out: Path, choice: Choice) -> Assembled:
    """Write `robot.urdf`, `table.obj` and `scene.json` into `out`.

    Raises:
        BadInput: one of the files is at fault.
    """
    arms = read_arms(robot)
    arm = Arm.from_urdf(robot / arms.urdf)
    home = np.array(arms.home_rad)
    if (home < arm.lower_rad).any() or (home > arm.upper_rad).any():
        raise BadInput(f"{robot}/arms.yaml: home_rad {arms.home_rad} is beyond the joint limits of {arms.urdf}")
    placement = place_arms(robot, arm, arms)
    table, size_m, tolerance_m = read_table(environment, choice.table)
    head, wrist = read_cameras(environment)
    if wrist.link not in arm.robot.links:
        raise BadInput(
            f"{environment}/cameras.yaml: wrist.link is {wrist.link!r}, the robot has {sorted(arm.robot.links)}"
        )
    vertices, faces, rgb = read_garment(garment_mesh)
    try:
        place = lying_pose(vertices, 0.0, choice.gap_m)
    except BadInput as error:
        raise BadInput(f"{garment_mesh}/mesh.npz: {error}") from error
    shutil.copyfile(robot / arms.urdf, out / "robot.urdf")
    (out / "table.obj").write_text(
        trimesh.exchange.obj.export_obj(table, include_normals=False, header="Table, metres")
    )
    scene = Scene(
        table_mesh=out / "table.obj",
        table_size_m=size_m,
        table_top_m=0.0,
        urdf=out / "robot.urdf",
        base_to_world=placement.base_to_world,
        home_rad=dict.fromkeys(ARMS, home),
        garment_place=place,
        cameras={"head": head},
        wrist_cameras=dict.fromkeys(ARMS, wrist),
    )
    write_scene(out, scene)
    return Assembled(
        scene=scene,
        arm=arm,
        planar=PlanarArm.of(arm),
        arms=arms,
        placement=placement,
        table=table,
        table_tolerance_m=tolerance_m,
        garment_m=vertices,
        garment_faces=faces,
        garment_rgb=rgb,
    )
