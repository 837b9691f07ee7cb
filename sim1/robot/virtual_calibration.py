"""Stand-in for touching marks with two real arms: writes `data/robot/calibration.yaml`.

    python -m sim1.robot.virtual_calibration data/robot

The bases stand a little off their nominal places, as bolted ones do; joint encoders and the survey of the marks have errors.
"""

import sys
from pathlib import Path

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from sim1.episode import ARMS
from sim1.robot.calibration import read_arms
from sim1.robot.kinematics import Arm
from sim1.stage import random_stream

ENCODER_RAD = 3e-4  # standard deviation
SURVEY_M = 2e-4
BASE_OFFSET_M = 2e-3
BASE_TURN_RAD = 3e-3
MARKS_M = [
    (x, y, z) for z in (0.0, 0.12) for x in (-0.12, 0.04) for y in (-0.12, 0.12)
]  # on the table, on gauge blocks


def calibrate_virtually(folder: Path, seed: int = 1) -> None:
    """Write the angles at which each of the two arms of `folder` touches the marks."""
    arms = read_arms(folder)
    arm = Arm.from_urdf(folder / arms.urdf)
    stream = random_stream(seed, "calibration")
    bases = {}
    for name in ARMS:
        pose = np.eye(4)
        pose[:3, :3] = Rotation.from_rotvec(stream.normal(0, BASE_TURN_RAD, 3)).as_matrix()
        pose[:3, 3] = np.array(arms.nominal_base_m[name]) + stream.normal(0, BASE_OFFSET_M, 3)
        bases[name] = pose
    marks = []
    for index, mark in enumerate(MARKS_M):
        entry = {"name": f"mark{index + 1}", "world_m": np.add(mark, stream.normal(0, SURVEY_M, 3)).round(5).tolist()}
        for name in ARMS:
            target = np.eye(4)
            target[:3, :3] = Rotation.from_euler("y", 65, degrees=True).as_matrix()  # forward and down
            target[:3, 3] = mark
            q = arm.inverse(np.linalg.inv(bases[name]) @ target, np.array(arms.home_rad))
            entry[f"{name}_rad"] = (q + stream.normal(0, ENCODER_RAD, 6)).round(6).tolist()
        marks.append(entry)
    document = {"schema": "sim1.calibration/1", "virtual": True, "marks": marks}
    head = (
        "# Joint angles at which each arm touches the same marks with closed finger tips; the marks surveyed from the table's\n"
        "# middle. VIRTUAL: made by sim1/robot/virtual_calibration.py, not measured on a robot.\n"
    )
    (folder / "calibration.yaml").write_text(head + yaml.safe_dump(document, sort_keys=False, default_flow_style=None))


if __name__ == "__main__":
    calibrate_virtually(Path(sys.argv[1]))
