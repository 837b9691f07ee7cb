"""A way of both tools through space at 30 Hz, put together from minimum-jerk pieces."""

import numpy as np

from sim1.robot.expert_variation import Variation, tremor

FRAME_S = 1.0 / 30.0


def min_jerk(share: np.ndarray) -> np.ndarray:
    """Position share of a minimum-jerk movement at time share 0..1 (Flash and Hogan 1985)."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


class Path3:
    """Positions (n, 2, 3) in metres and openness (n, 2), grown piece by piece from a first frame."""

    def __init__(self, start: np.ndarray, openness: float) -> None:
        self._positions = [np.array(start, float)[None]]
        self._openness = [np.full((1, 2), openness)]

    def move(self, target: np.ndarray, seconds: float) -> None:
        """Straight to `target` (2, 3)."""
        here = self._positions[-1][-1]
        self._add(here + min_jerk(_shares(seconds))[:, None, None] * (target - here))

    def arc(self, target: np.ndarray, height: float, seconds: float, variation: Variation) -> None:
        """Up, over and down to `target` (2, 3) on half an ellipse, which keeps a turned flap taut, with tremor."""
        here = self._positions[-1][-1]
        time = _shares(seconds)
        angle = np.pi * min_jerk(time)
        way = here + (0.5 - 0.5 * np.cos(angle))[:, None, None] * (target - here)
        way[:, :, 2] += height * np.sin(angle)[:, None]
        self._add(way + tremor(variation, time))

    def hold(self, seconds: float) -> None:
        """Stay."""
        count = round(seconds / FRAME_S)
        self._add(np.repeat(self._positions[-1][-1:], count, axis=0))

    def grip(self, openness: float, seconds: float) -> None:
        """Stay, and move the fingers to `openness`."""
        share = min_jerk(_shares(seconds))[:, None]
        change = self._openness[-1][-1] + share * (openness - self._openness[-1][-1])
        self._positions.append(np.repeat(self._positions[-1][-1:], len(share), axis=0))
        self._openness.append(change)

    def positions(self) -> np.ndarray:
        """All frames, (n, 2, 3)."""
        return np.concatenate(self._positions)

    def openness(self) -> np.ndarray:
        """All frames, (n, 2)."""
        return np.concatenate(self._openness)

    def _add(self, positions: np.ndarray) -> None:
        if len(positions):
            self._positions.append(positions)
            self._openness.append(np.repeat(self._openness[-1][-1:], len(positions), axis=0))


def _shares(seconds: float) -> np.ndarray:
    """Time shares of the frames of a piece, the last one 1."""
    count = max(1, round(seconds / FRAME_S))
    return np.arange(1, count + 1) / count
