"""Between which values states and actions of a dataset lie: the robot's joint limits, and openness from closed to open."""

import json
from pathlib import Path

import numpy as np

from sim1.episode import ARMS
from sim1.robot.calibration import read_arms
from sim1.robot.kinematics import Arm
from sim1.stage import BadInput

FILE = "limits.json"


def write_limits(artifact: Path, robot: Path) -> None:
    """Write `limits.json` for two arms as in `data/robot/`: `lower` and `upper`, 14 numbers each [rad, openness].

    Raises:
        BadInput: a file in there is damaged.
    """
    arm = Arm.from_urdf(robot / read_arms(robot).urdf)
    limits = {
        "lower": [*arm.lower_rad.tolist(), 0.0] * len(ARMS),
        "upper": [*arm.upper_rad.tolist(), 1.0] * len(ARMS),
    }
    (artifact / FILE).write_text(json.dumps(limits, indent=1) + "\n")


def read_limits(artifact: Path) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper limits, (14,) each, in the order of `observation.state`.

    Raises:
        BadInput: the file is missing or damaged.
    """
    path = artifact / FILE
    try:
        limits = json.loads(path.read_text())
        return np.array(limits["lower"], float), np.array(limits["upper"], float)
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise BadInput(f"{path}: not readable limits ({error!r}); make the dataset again") from error
