"""How far apart two fitted models are in what they say of each recording: where a repetition would tell them from each other."""

from dataclasses import dataclass

import numpy as np

from sim1.mismatch.fit import Fit


@dataclass(frozen=True, kw_only=True)
class Apart:
    """Two models in one recording."""

    recording: str
    noises: float  # root mean square of the difference, in units of noise and mesh error


def apart(one: Fit, other: Fit) -> tuple[Apart, ...]:
    """Two models by the recordings that they were fitted to, the one in which they differ most first.

    Residuals of both are in units of noise and mesh error and hold the same measurements: their difference is that of what was
    simulated along the way, and nothing is simulated for it.
    """
    rows = [Apart(recording=name, noises=_rms(one.residuals[name] - other.residuals[name])) for name in one.names]
    return tuple(sorted(rows, key=lambda row: -row.noises))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.square(values).mean()))
