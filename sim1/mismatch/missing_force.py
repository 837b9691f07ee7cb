"""The force that a model lacks at every marker of a recording, and what the sheet does there."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sim1.cloth.precise.marker_states import MarkerStates


@dataclass(frozen=True, kw_only=True)
class Forces:
    """Missing force in one recording, along the motion of the markers that it was found with."""

    name: str
    time_s: np.ndarray  # (T,)
    force_n: np.ndarray  # (T, M, 3)
    floor_n: float  # rms per coordinate that noise alone makes
    path_m: np.ndarray  # (T, M, 3)
    states: MarkerStates
    table_z_m: float | None  # where the middle surface rests; None: there is no table

    @cached_property
    def velocity_m_s(self) -> np.ndarray:
        """Of the markers, (T, M, 3)."""
        return np.gradient(self.path_m, self.time_s, axis=0)
