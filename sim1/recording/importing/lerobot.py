"""Drives from the joints of a LeRobot dataset (version 3): the project's robot, its calibration, forward kinematics."""

from pathlib import Path

import numpy as np
import pandas as pd

from sim1.recording.importing.lerobot_episode import Episode, read_episode
from sim1.recording.places import Places
from sim1.recording.streams import VALUE_COLUMNS, Drives, drives_of
from sim1.stage import BadInput

BEYOND_RAD = 0.1  # past a joint's stop: an encoder's zero is no better known
BEYOND_OPEN = 1e-4  # past open or closed: single precision and an encoder's rounding


def read_lerobot_drives(dataset: Path, episode: int, robot: Path, use: str = "action") -> Drives:
    """Gripper frames in the world of one episode of a LeRobot dataset (v3) recorded with the project's robot.

    Args:
        dataset: folder with `meta/info.json` and `data/`.
        episode: its index.
        robot: folder with `arms.yaml`, the URDF and `calibration.yaml`.
        use: the column: "action" is what was commanded, "observation.state" what the encoders measured.

    Raises:
        BadInput: not such a dataset, no such episode, joints with other names, a value that is not finite, a joint beyond its
            stops, an openness outside 0 to 1, a damaged path; names the data file, the row, the episode and the frame.
    """
    from scipy.spatial.transform import Rotation

    from sim1.episode import ARMS, JOINT_COUNT
    from sim1.robot.calibration import place_arms, read_arms
    from sim1.robot.kinematics import Arm

    told = read_episode(dataset, episode, use)
    arms = read_arms(robot)
    arm = Arm.from_urdf(robot / arms.urdf)
    placed = place_arms(robot, arm, arms).base_to_world
    tables = []
    for side in ARMS:
        wanted = [*(f"{side}_joint_{k + 1}_rad" for k in range(JOINT_COUNT)), f"{side}_openness"]
        if not set(wanted) & set(told.names):
            continue
        if lacking := [name for name in wanted if name not in told.names]:
            raise BadInput(f"{dataset}/meta/info.json: {use} has no {lacking[0]!r}; its names are {told.names}")
        part = _finite(told, wanted)
        angles = part[:, :JOINT_COUNT]
        if (beyond := (angles < arm.lower_rad - BEYOND_RAD) | (angles > arm.upper_rad + BEYOND_RAD)).any():
            frame, joint = np.argwhere(beyond)[0]
            raise BadInput(
                f"{told.place(frame)}: {use} {wanted[joint]} is {angles[frame, joint]:.4g}, beyond the arm's "
                f"{arm.lower_rad[joint]:.3g} to {arm.upper_rad[joint]:.3g} rad; expected rad: are these degrees?"
            )
        pose = placed[side] @ arm.forward(angles)
        turned = Rotation.from_matrix(pose[:, :3, :3]).as_quat(scalar_first=True)
        columns = np.column_stack([told.time_s, pose[:, :3, 3], turned, _openness(told, wanted[-1])])
        tables.append(pd.DataFrame(columns, columns=list(VALUE_COLUMNS)).assign(drive=side))
    if not tables:
        raise BadInput(
            f"{dataset}/meta/info.json: {use} names {told.names}; expected left_joint_1_rad to right_openness"
        )
    return drives_of(Places(file=told.files[0], row=told.place), pd.concat(tables))


def _finite(told: Episode, names: list[str]) -> np.ndarray:
    """The values (n, k) of these names."""
    values = told.values[:, [told.names.index(name) for name in names]]
    if (bad := ~np.isfinite(values)).any():
        frame, column = np.argwhere(bad)[0]
        raise BadInput(
            f"{told.place(frame)}: {told.column} {names[column]} is {values[frame, column]}; expected a finite number in every frame: "
            "repair the dataset, or take another episode"
        )
    return values


def _openness(told: Episode, name: str) -> np.ndarray:
    """Openness (n,) in [0, 1], what is past it by rounding alone moved onto it."""
    openness = told.values[:, told.names.index(name)]
    if (off := (openness < -BEYOND_OPEN) | (openness > 1 + BEYOND_OPEN)).any():
        frame = int(np.argmax(off))
        raise BadInput(
            f"{told.place(frame)}: {told.column} {name} is {openness[frame]:.6g}; expected 0 (closed) to 1 (open): "
            "bring it to that scale (per cent: divide by 100)"
        )
    return np.clip(openness, 0, 1)
