"""What one recording is made in, and the state that is integrated."""

from dataclasses import dataclass, field

import numpy as np

from benchmarks.concealed.cloth import Cloth
from benchmarks.concealed.grips import Holds
from benchmarks.concealed.motions.motion import Motion
from benchmarks.concealed.sheet import Sheet
from benchmarks.concealed.table import Friction


@dataclass(frozen=True)
class Environment:
    """Everything around the cloth. SI units, z up."""

    gravity_m_s2: np.ndarray
    air_density_kg_m3: float
    table_m: float | None
    friction: Friction


@dataclass(frozen=True)
class World:
    """One recording's world: as it is, and as the baseline would have it."""

    cloth: Cloth
    motion: Motion
    holds: Holds
    sheet: Sheet
    environment: Environment
    baseline_sheet: Sheet
    baseline_environment: Environment


@dataclass
class State:
    """Positions and velocities (3, count) on the grid's flat axis, and what was last measured on them."""

    x: np.ndarray
    v: np.ndarray
    drives: int
    time_s: float = 0.0
    relaxing: bool = True
    """While the cloth is brought to rest before the recording: time stands still, wear and tear has not begun."""
    drive_rotation: np.ndarray = field(init=False)
    """(D, 3, 3) true orientation of each drive."""
    grip_load_n: np.ndarray = field(init=False)
    """(D, 3) force of the cloth on each gripper."""

    def __post_init__(self) -> None:
        """Nothing measured yet."""
        self.drive_rotation = np.tile(np.eye(3), (self.drives, 1, 1))
        self.grip_load_n = np.zeros((self.drives, 3))
