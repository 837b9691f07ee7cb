"""Human-like variation of a demonstration: nobody folds twice alike."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Standard deviations of what varies from one demonstration to the next."""

    grasp_m: float = 0.005  # of the grasp point, each of x and y
    lift_m: float = 0.012  # of the arc's height
    pace: float = 0.12  # of the logarithm of all durations
    pause_s: float = 0.08  # mean of the pauses before grasping and before letting go (exponential)
    tremor_m: float = 0.0015  # amplitude of the smooth deviation from the planned path


@dataclass(frozen=True, kw_only=True)
class Variation:
    """One draw."""

    grasp_shift_m: np.ndarray  # (2, 2) arm, x and y
    lift_shift_m: float
    pace: float  # all durations are multiplied by it
    pauses_s: np.ndarray  # (2,) before grasping, before letting go
    tremor_m: float
    tremor_phase: np.ndarray  # (2, 3, 3) arm, axis, wave
    tremor_share: np.ndarray  # (2, 3, 3) of the waves


PLAIN = Variation(
    grasp_shift_m=np.zeros((2, 2)),
    lift_shift_m=0.0,
    pace=1.0,
    pauses_s=np.zeros(2),
    tremor_m=0.0,
    tremor_phase=np.zeros((2, 3, 3)),
    tremor_share=np.zeros((2, 3, 3)),
)
"""No variation at all."""


def draw_variation(stream: np.random.Generator, spread: Spread) -> Variation:
    """Draw one; deviations are cut at two standard deviations, so that a draw varies the fold rather than breaks it."""

    def cut(size: int | tuple[int, ...] | None = None) -> np.ndarray:
        return np.clip(stream.standard_normal(size), -2.0, 2.0)

    share = stream.uniform(0.2, 1.0, (2, 3, 3))
    return Variation(
        grasp_shift_m=spread.grasp_m * cut((2, 2)),
        lift_shift_m=float(spread.lift_m * cut()),
        pace=float(np.exp(spread.pace * cut())),
        pauses_s=np.minimum(stream.exponential(spread.pause_s, 2), 0.4),
        tremor_m=spread.tremor_m,
        tremor_phase=stream.uniform(0.0, 2.0 * np.pi, (2, 3, 3)),
        tremor_share=share / share.sum(axis=2, keepdims=True),
    )


def tremor(variation: Variation, share: np.ndarray) -> np.ndarray:
    """Smooth deviation [m] (n, 2, 3) along a movement done by `share` (n,) in 0..1; nothing at both ends."""
    waves = np.arange(1, 4)
    angle = 2.0 * np.pi * share[:, None, None, None] * waves + variation.tremor_phase
    window = np.sin(np.pi * share) ** 2
    return variation.tremor_m * window[:, None, None] * (variation.tremor_share * np.sin(angle)).sum(axis=3)
