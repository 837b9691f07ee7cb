"""Checks of a `scene` artifact, from its files alone."""

import json
from pathlib import Path

import numpy as np
import trimesh
from pxr import Usd, UsdGeom

from sim1.robot.gripper import FINGER_TRAVEL_M
from sim1.robot.kinematics import Arm
from sim1.robot.planar import PlanarArm
from sim1.scene.description import Scene, read_scene
from sim1.scene.parts import arm_parts
from sim1.scene.reach import reach_of
from sim1.scene.usd import garment_points
from sim1.stage import Finding

STANDING_M = 0.006  # a calibrated base floats or sinks this much at most
APART_M = 0.10  # between the two arms at home
CLEAR_M = 0.07  # from a base's axis; half the diagonal of its foot is 0.05
FARTHEST_LIMIT_RAD = 3.2  # a joint that turns farther is no arm joint: degrees in the URDF?


def findings(artifact: Path) -> list[Finding]:
    """All findings.

    Raises:
        BadInput, OSError, LookupError, ValueError: the artifact cannot be read.
    """
    scene = read_scene(artifact)
    arm = Arm.from_urdf(scene.urdf)
    measured = json.loads((artifact / "measured.json").read_text())
    lying = garment_points(artifact / "scene.usda")
    return [
        _table(scene, measured["table_tolerance_m"]),
        _limits(scene, arm),
        _standing(scene, arm),
        _apart(scene, arm),
        _garment(scene, lying),
        _clear(scene, lying),
        _reach(scene, arm, lying, measured),
        _calibration(measured),
        _usd(artifact / "scene.usda"),
    ]


def _table(scene: Scene, tolerance_m: float) -> Finding:
    mesh = trimesh.load_mesh(scene.table_mesh, process=False)
    gap = float(np.abs(mesh.extents - scene.table_size_m).max())
    top = abs(float(mesh.bounds[1, 2]) - scene.table_top_m)
    return Finding(
        name="table_has_measured_size",
        passed=gap <= tolerance_m and top < 1e-6,
        detail=f"largest difference {1000 * gap:.1f} mm (limit {1000 * tolerance_m:.1f}), top {1000 * top:.3f} mm off",
    )


def _limits(scene: Scene, arm: Arm) -> Finding:
    farthest = float(max(np.abs(arm.lower_rad).max(), np.abs(arm.upper_rad).max()))
    fingers = [joint.upper for joint in arm.robot.joints.values() if joint.kind == "prismatic"]
    inside = all(((arm.lower_rad <= q) & (q <= arm.upper_rad)).all() for q in scene.home_rad.values())
    return Finding(
        name="joint_limits_make_sense",
        passed=farthest <= FARTHEST_LIMIT_RAD
        and inside
        and np.allclose(fingers, FINGER_TRAVEL_M)
        and len(fingers) == 2,
        detail=f"joints within {farthest:.2f} rad, finger travel {fingers} m, home {'inside' if inside else 'outside'}",
    )


def _standing(scene: Scene, arm: Arm) -> Finding:
    feet = {
        part.path.split("/")[1]: min(float((v @ part.pose[2, :3] + part.pose[2, 3]).min()) for v, _, _ in part.meshes)
        for part in arm_parts(scene, arm)
        if part.path.endswith("/base_link")
    }
    worst = max(abs(z - scene.table_top_m) for z in feet.values())
    return Finding(
        name="arms_stand_on_table",
        passed=worst <= STANDING_M,
        detail=f"feet {1000 * worst:.1f} mm off the table top (limit {1000 * STANDING_M:.0f} mm)",
    )


def _apart(scene: Scene, arm: Arm) -> Finding:
    clouds: dict[str, list[np.ndarray]] = {}
    for part in arm_parts(scene, arm):
        points = [v @ part.pose[:3, :3].T + part.pose[:3, 3] for v, _, _ in part.meshes]
        clouds.setdefault(part.path.split("/")[1], []).extend(points)
    left, right = (np.concatenate(clouds[name]) for name in ("left", "right"))
    gap = float(np.linalg.norm(left[:, None] - right[None], axis=-1).min())
    return Finding(
        name="arms_apart_at_home",
        passed=gap >= APART_M,
        detail=f"{gap:.3f} m between the arms at home (limit {APART_M} m)",
    )


def _garment(scene: Scene, lying: np.ndarray) -> Finding:
    margin = float((scene.table_size_m[:2] / 2 - np.abs(lying[:, :2]).max(axis=0)).min())
    above = float(lying[:, 2].min() - scene.table_top_m)
    return Finding(
        name="garment_lies_on_table",
        passed=margin >= 0 and 0 < above < 0.05,
        detail=f"{margin:.3f} m from the table's edge (limit 0), {1000 * above:.1f} mm above its top (limit 0 to 50)",
    )


def _clear(scene: Scene, lying: np.ndarray) -> Finding:
    gaps = [np.linalg.norm(lying[:, :2] - base[:2, 3], axis=1).min() for base in scene.base_to_world.values()]
    return Finding(
        name="garment_clear_of_arms",
        passed=min(gaps) >= CLEAR_M,
        detail=f"{min(gaps):.3f} m from the nearer arm's first axis (limit {CLEAR_M} m)",
    )


def _reach(scene: Scene, arm: Arm, lying: np.ndarray, measured: dict) -> Finding:
    grasped = np.column_stack([lying[:, :2], np.full(len(lying), scene.table_top_m + measured["grasp_height_m"])])
    share = reach_of(grasped, scene, PlanarArm.of(arm)).share(measured["largest_tilt_deg"])
    limit = measured["smallest_reached_share"]
    return Finding(
        name="garment_within_reach",
        passed=share >= limit,
        detail=f"{100 * share:.1f} % of the garment's points, tool leaning by {measured['largest_tilt_deg']:.0f} degrees"
        f" at most (limit {100 * limit:.0f} %)",
    )


def _calibration(measured: dict) -> Finding:
    between, world = (measured[f"calibration_{key}_rms_mm"] for key in ("between_arms", "to_world"))
    limit = measured["calibration_largest_residual_mm"]
    kind = "virtual calibration" if measured["calibration_virtual"] else "measured calibration"
    return Finding(
        name="arms_calibrated",
        passed=max(between, world) <= limit,
        detail=f"{kind}: {between:.2f} mm RMS between the arms, {world:.2f} mm to the world (limit {limit} mm)",
    )


def _usd(path: Path) -> Finding:
    stage = Usd.Stage.Open(str(path))
    metres, axis = UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage)
    layers = [layer for layer in stage.GetUsedLayers() if not layer.anonymous]
    meshes = sum(prim.IsA(UsdGeom.Mesh) for prim in stage.Traverse())
    return Finding(
        name="usd_is_metric_and_complete",
        passed=metres == 1.0 and axis == "Z" and len(layers) == 1 and meshes > 20,
        detail=f"{metres} m per unit, {axis} up, {meshes} meshes, {len(layers)} file",
    )
