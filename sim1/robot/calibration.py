"""Where the two arms stand, from both touching the same marks (SIM1, robot: "calibrated relative to each other")."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.data_file import read_data_file
from sim1.episode import ARMS
from sim1.robot.kinematics import Arm
from sim1.stage import BadInput, stage_config

type Vector3 = tuple[float, float, float]
type Angles = tuple[float, float, float, float, float, float]


@stage_config
class Mark:
    """A mark that both arms touched with their closed finger tips."""

    name: str
    world_m: Vector3  # surveyed
    left_rad: Angles
    right_rad: Angles


@stage_config
class CalibrationFile:
    """Contents of `calibration.yaml`."""

    virtual: bool  # made by the project's model of a calibration, not measured
    marks: list[Mark]


@stage_config
class ArmsFile:
    """Contents of `arms.yaml`."""

    urdf: str
    nominal_base_m: dict[str, Vector3]
    home_rad: Angles
    largest_offset_m: float
    largest_turn_deg: float
    largest_residual_mm: float


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Result of the calibration."""

    base_to_world: dict[str, np.ndarray]  # arm -> (4, 4)
    between_arms_rms_mm: float  # of the marks as one arm sees them against the other
    to_world_rms_mm: float  # of the left arm's touches against the surveyed marks
    virtual: bool
    mark_count: int


def read_arms(folder: Path) -> ArmsFile:
    """Read `arms.yaml` of `data/robot/`.

    Raises:
        BadInput: the file is damaged, or names other arms than left and right.
    """
    arms = read_data_file(folder / "arms.yaml", ArmsFile, "sim1.arms/1")
    if sorted(arms.nominal_base_m) != sorted(ARMS):
        raise BadInput(
            f"{folder}/arms.yaml: nominal_base_m names {sorted(arms.nominal_base_m)}, expected {sorted(ARMS)}"
        )
    return arms


def place_arms(folder: Path, arm: Arm, arms: ArmsFile) -> Placement:
    """Place both arms by `calibration.yaml` of `data/robot/`.

    The left arm is laid on the surveyed marks, the right arm on the left arm's touches of the same marks, so that the
    survey's error does not come between the arms.

    Raises:
        BadInput: fewer than four marks or all on a line, joint angles beyond the limits, residual too large, or a base
            far from its nominal place.
    """
    path = folder / "calibration.yaml"
    file = read_data_file(path, CalibrationFile, "sim1.calibration/1")
    world = np.array([mark.world_m for mark in file.marks], float).reshape(-1, 3)
    if len(world) < 4 or np.linalg.svd(world - world.mean(axis=0), compute_uv=False)[1] < 0.05:
        raise BadInput(
            f"{path}: {len(world)} marks, or all near one line; touch at least four marks apart from each other"
        )
    touched = {}
    for name in ARMS:
        angles = np.array([getattr(mark, f"{name}_rad") for mark in file.marks])
        outside = ((angles < arm.lower_rad - 0.01) | (angles > arm.upper_rad + 0.01)).any(axis=1)
        if outside.any():
            mark = file.marks[int(np.argmax(outside))]
            raise BadInput(f"{path}: mark {mark.name!r}: {name}_rad is beyond the joint limits; is it in degrees?")
        touched[name] = arm.forward(angles)[:, :3, 3]
    left, to_world = lay(touched["left"], world)
    relative, between = lay(touched["right"], touched["left"])
    placement = Placement(
        base_to_world={"left": left, "right": left @ relative},
        between_arms_rms_mm=between,
        to_world_rms_mm=to_world,
        virtual=file.virtual,
        mark_count=len(world),
    )
    _check(path, placement, arms)
    return placement


def lay(points: np.ndarray, onto: np.ndarray) -> tuple[np.ndarray, float]:
    """Rigid motion (4, 4) that lays `points` (n, 3) onto `onto` (n, 3) with least squares, and its residual in mm RMS."""
    turn = Rotation.align_vectors(onto - onto.mean(axis=0), points - points.mean(axis=0))[0].as_matrix()
    pose = np.eye(4)
    pose[:3, :3] = turn
    pose[:3, 3] = onto.mean(axis=0) - turn @ points.mean(axis=0)
    gaps = points @ turn.T + pose[:3, 3] - onto
    return pose, 1000 * float(np.sqrt((gaps**2).sum(axis=1).mean()))


def _check(path: Path, placement: Placement, arms: ArmsFile) -> None:
    worst = max(placement.between_arms_rms_mm, placement.to_world_rms_mm)
    if worst > arms.largest_residual_mm:
        raise BadInput(
            f"{path}: residual {worst:.2f} mm RMS, at most {arms.largest_residual_mm} mm; touch the marks again"
        )
    for name in ARMS:
        pose = placement.base_to_world[name]
        offset = float(np.linalg.norm(pose[:3, 3] - arms.nominal_base_m[name]))
        turn = float(np.degrees(Rotation.from_matrix(pose[:3, :3]).magnitude()))
        if offset > arms.largest_offset_m or turn > arms.largest_turn_deg:
            raise BadInput(
                f"{path}: the {name} base comes out {1000 * offset:.1f} mm and {turn:.2f} degrees from its nominal place"
                f" (arms.yaml allows {1000 * arms.largest_offset_m:.0f} mm, {arms.largest_turn_deg} degrees);"
                " correct the marks or the nominal place"
            )
