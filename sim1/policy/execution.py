"""From predicted chunks to one command per frame."""

from collections.abc import Callable

import numpy as np

type Predict = Callable[[], np.ndarray]
"""Chunk (chunk_frames, action_size) from what is seen now, first row for the current frame."""


class ChunkExecution:
    """Asks for a new chunk every `replan_frames` frames and averages what the chunks say about a frame.

    Weights exp(-decay * age), age in chunks, the newest chunk weighs most. A large decay executes the newest chunk
    alone (receding horizon); 0 averages all of them (temporal ensembling, Zhao et al. 2023, ACT, which favours old ones).
    """

    def __init__(self, predict: Predict, replan_frames: int, decay: float) -> None:
        if replan_frames < 1:
            raise ValueError(f"replan_frames must be at least 1 (got {replan_frames})")
        self._predict = predict
        self._replan_frames = replan_frames
        self._decay = decay
        self._chunks: list[tuple[int, np.ndarray]] = []  # (frame of the first row, chunk), oldest first
        self._frame = 0

    def command(self) -> np.ndarray:
        """Command (action_size,) of this frame; call once per frame.

        Raises:
            ValueError: the chunks do not reach that far.
        """
        if self._frame % self._replan_frames == 0:
            self._chunks.append((self._frame, self._predict()))
        self._chunks = [(start, chunk) for start, chunk in self._chunks if self._frame < start + len(chunk)]
        rows = [chunk[self._frame - start] for start, chunk in self._chunks]
        if not rows:
            raise ValueError(
                f"no chunk reaches frame {self._frame}: chunks must be at least {self._replan_frames} frames long"
            )
        self._frame += 1
        weights = np.exp(-self._decay * np.arange(len(rows))[::-1])
        return weights @ np.stack(rows) / weights.sum()
