"""Drives from the joints of a LeRobot dataset (version 3): the project's robot, its calibration, forward kinematics."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.recording.places import own_places
from sim1.recording.streams import VALUE_COLUMNS, Drives, drives_of
from sim1.stage import BadInput

BEYOND_RAD = 0.1  # past a joint's stop: an encoder's zero is no better known


def read_lerobot_drives(dataset: Path, episode: int, robot: Path, use: str = "action") -> Drives:
    """Gripper frames in the world of one episode of a LeRobot dataset (v3) recorded with the project's robot.

    Args:
        dataset: folder with `meta/info.json` and `data/`.
        episode: its index.
        robot: folder with `arms.yaml`, the URDF and `calibration.yaml`.
        use: the column: "action" is what was commanded, "observation.state" what the encoders measured.

    Raises:
        BadInput: not such a dataset, no such episode, joints with other names, a damaged path.
    """
    from scipy.spatial.transform import Rotation

    from sim1.episode import ARMS, JOINT_COUNT
    from sim1.robot.calibration import place_arms, read_arms
    from sim1.robot.kinematics import Arm

    names, time, values = _episode(dataset, episode, use)
    arms = read_arms(robot)
    arm = Arm.from_urdf(robot / arms.urdf)
    placed = place_arms(robot, arm, arms).base_to_world
    tables = []
    for side in ARMS:
        wanted = [*(f"{side}_joint_{k + 1}_rad" for k in range(JOINT_COUNT)), f"{side}_openness"]
        if not set(wanted) & set(names):
            continue
        if lacking := [name for name in wanted if name not in names]:
            raise BadInput(f"{dataset}/meta/info.json: {use} has no {lacking[0]!r}; its names are {names}")
        part = values[:, [names.index(name) for name in wanted]]
        angles = part[:, :JOINT_COUNT]
        if (beyond := (angles < arm.lower_rad - BEYOND_RAD) | (angles > arm.upper_rad + BEYOND_RAD)).any():
            frame, joint = np.argwhere(beyond)[0]
            raise BadInput(
                f"{dataset}: episode {episode}: {wanted[joint]} is {angles[frame, joint]:.4g} at {time[frame]:.3f} s, beyond the arm's "
                f"{arm.lower_rad[joint]:.3g} to {arm.upper_rad[joint]:.3g} rad; expected rad: are these degrees?"
            )
        pose = placed[side] @ arm.forward(angles)
        table = np.column_stack(
            [
                time,
                pose[:, :3, 3],
                Rotation.from_matrix(pose[:, :3, :3]).as_quat(scalar_first=True),
                part[:, JOINT_COUNT],
            ]
        )
        table[:, -1] = np.clip(table[:, -1], 0, 1)  # float32 may be a hair beyond
        tables.append(pd.DataFrame(table, columns=list(VALUE_COLUMNS)).assign(drive=side))
    if not tables:
        raise BadInput(f"{dataset}/meta/info.json: {use} names {names}; expected left_joint_1_rad to right_openness")
    return drives_of(own_places(dataset), pd.concat(tables))


def _episode(dataset: Path, episode: int, use: str) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Names (k), time stamps (n,) and values (n, k) of a column of one episode."""
    path = dataset / "meta" / "info.json"
    try:
        info = json.loads(path.read_text(encoding="utf-8"))
        version, names = str(info["codebase_version"]), info["features"][use]["names"]
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: not readable ({error}); expected a LeRobot dataset, version 3") from error
    except (KeyError, TypeError) as error:
        raise BadInput(
            f"{path}: no codebase_version or no features.{use}.names; expected a LeRobot dataset, version 3"
        ) from error
    if not version.startswith("v3"):
        raise BadInput(f"{path}: codebase_version is {version!r}; convert the dataset to version 3 with lerobot")
    names = next(iter(names.values())) if isinstance(names, dict) and names else names
    files = sorted((dataset / "data").rglob("*.parquet"))
    if not files:
        raise BadInput(f"{dataset}/data: no Parquet file; the dataset's data are missing")
    parts = []
    for file in files:
        try:
            table = pd.read_parquet(file, columns=["episode_index", "timestamp", use])
        except Exception as error:  # damaged Parquet raises many kinds
            raise BadInput(f"{file}: not readable ({' '.join(str(error).split())[:120]})") from error
        parts.append(table[table["episode_index"] == episode])
    found = pd.concat(parts, ignore_index=True)
    if found.empty:
        raise BadInput(f"{dataset}: there is no episode {episode}; info.json counts {info.get('total_episodes')}")
    values = np.array([np.ravel(row) for row in found[use]], float)
    if values.ndim != 2 or values.shape[1] != len(names):
        raise BadInput(f"{dataset}: episode {episode}: {use} has {values.shape} values for {len(names)} names")
    return [str(name) for name in names], found["timestamp"].to_numpy(float), values
