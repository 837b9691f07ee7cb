"""Where demonstrations start: the garment as it lies before anything moves, and the arms in their home."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.episode import Episode, episode_folders, read_episode, read_start
from sim1.stage import BadInput


@dataclass(frozen=True, kw_only=True)
class Home:
    """The start that all demonstrations of a garment share."""

    start_m: np.ndarray  # (v, 3) garment settled on the table
    joints_rad: np.ndarray  # (2, 6)
    openness: np.ndarray  # (2,) of the grippers at rest, where a path ends
    first_openness: np.ndarray  # (2,) first command: a demonstration opens for the grasp before it moves


def home_of(start_m: np.ndarray, demo: Episode) -> Home:
    """The home from which `demo` started."""
    return Home(
        start_m=start_m,
        joints_rad=demo.joints_rad[0],
        openness=demo.openness[0],
        first_openness=demo.command_openness[0],
    )


def read_home(demos: Path) -> Home:
    """The home of an artifact of demonstrations.

    Raises:
        BadInput: there is no demonstration, or a file is missing or damaged.
    """
    return home_of(read_start(demos), read_episode(demo_folders(demos)[0]))


def demo_folders(demos: Path) -> list[Path]:
    """Folders of all demonstrations of an artifact.

    Raises:
        BadInput: there is none.
    """
    folders = episode_folders(demos)
    if not folders:
        raise BadInput(f"{demos}/episodes: no demonstration; make seed_demos again")
    return folders
