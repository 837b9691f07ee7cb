"""What a bundle holds once it is read: one garment, its recordings, and what the robot was told."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.recording.document import Environment, Priors
from sim1.recording.mesh import RestMesh
from sim1.recording.streams import Anchors, Track


@dataclass(frozen=True, kw_only=True)
class Hold:
    """Mesh vertices that move rigidly with a drive for a while."""

    drive: str
    vertices: np.ndarray  # (h,)
    from_s: float
    to_s: float
    places_m: np.ndarray | None  # (h, 3) in the drive's frame; None: not measured


@dataclass(frozen=True, kw_only=True)
class Recording:
    """One motion: T frames of M markers, and what the drives were told."""

    name: str
    starts: str  # "rest" or "moving"
    holds: tuple[Hold, ...]
    time_s: np.ndarray  # (T,) clock of the markers
    markers_m: np.ndarray  # (T, M, 3), NaN where a marker was not seen
    drives: dict[str, Track]

    @property
    def seen(self) -> np.ndarray:
        """Whether each marker was seen, (T, M)."""
        return np.isfinite(self.markers_m).all(-1)


@dataclass(frozen=True, kw_only=True)
class Bundle:
    """One garment and its recorded motions."""

    mesh: RestMesh
    prior: Priors
    environment: Environment
    noise_std_m: float | None  # of the markers, per coordinate; None: not known
    anchors: Anchors
    recordings: tuple[Recording, ...]
    folder: Path = Path()  # where it was read from, for messages
