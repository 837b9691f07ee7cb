"""What an effect may change: the sheet, the surroundings, the robot, forces in between, or the measurement."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from benchmarks.concealed.grips import Poses
from benchmarks.concealed.sheet import Sheet
from benchmarks.concealed.world import Environment, State, World

Sampler = Callable[[np.ndarray], np.ndarray]
"""True times (F, M), one per frame and marker, to positions (F, M, 3)."""


@dataclass
class Effect:
    """Nothing on top of the baseline. An effect overrides what it changes, and keeps its inner state from `begin` on."""

    name: ClassVar[str] = "none"
    formula: ClassVar[str] = ""
    """What is computed, in a line, for the answer file."""
    parameters: dict[str, float] = field(default_factory=dict)
    extras: dict[str, float] = field(default_factory=dict)
    """True values that the format's table has no name for."""
    measures_only: ClassVar[bool] = False
    """Whether the cloth itself moves as without the effect."""

    def sheet(self, sheet: Sheet) -> Sheet:
        """Changed material."""
        return sheet

    def environment(self, environment: Environment) -> Environment:
        """Changed surroundings."""
        return environment

    def poses(self, times_s: np.ndarray, poses: Poses) -> Poses:
        """Where the drives truly are, from where they are told to be; times are evenly spaced from 0 on."""
        return poses

    def begin(self, world: World) -> None:
        """Before the relaxation of each recording: forget the last one."""

    def advance(self, state: State, step_s: float) -> None:
        """Once per step, before the forces: inner variables go on."""

    def add_force(self, state: State, out_n: np.ndarray) -> None:
        """Add forces (3, count) at this state, leaving all inner variables as they are."""

    def carried(self, state: State) -> np.ndarray | None:
        """(count,) mass in kg carried along the normal of each vertex, beside the sheet's own."""
        return None

    def grip_shift(self, state: State) -> np.ndarray | None:
        """(K, 3) by how much the held vertices are off where their drives have them."""
        return None

    def observe(self, stamps_s: np.ndarray, sample: Sampler) -> np.ndarray:
        """Positions (F, M, 3) reported for the time stamps (F, M)."""
        return sample(stamps_s)
