"""A policy in control of the simulated cell."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from sim1.episode import RATE_HZ
from sim1.policy.execution import ChunkExecution
from sim1.policy.model import ChunkPolicy


class Cell(Protocol):
    """What a rollout needs of the robot cell (`sim1.cloth.cell.Cell`)."""

    garment_m: np.ndarray  # (v, 3)
    joints_rad: np.ndarray  # (2, 6)
    openness: np.ndarray  # (2,)

    def reset(self, garment_m: np.ndarray, joints_rad: np.ndarray, openness: np.ndarray) -> None: ...
    def step(self, joints_rad: np.ndarray, openness: np.ndarray) -> None: ...


@dataclass(frozen=True, kw_only=True)
class Start:
    """The cell before a trial."""

    garment_m: np.ndarray  # (v, 3) lying still on the table
    joints_rad: np.ndarray  # (2, 6)
    openness: np.ndarray  # (2,)


@dataclass(frozen=True, kw_only=True)
class Driving:
    """How chunks become commands."""

    rate_hz: int  # of the policy; a divisor of the cell's 30 Hz
    replan_frames: int  # of the policy
    decay: float

    @property
    def stride(self) -> int:
        """Cell frames per policy frame."""
        return round(RATE_HZ / self.rate_hz)


def roll_out(
    cell: Cell,
    start: Start,
    policy: ChunkPolicy,
    garment: str,
    keypoints: np.ndarray,
    driving: Driving,
    duration_s: float,
) -> Iterator[np.ndarray]:
    """Let the policy drive for `duration_s`; what came before a cell broke is known, too.

    What it says in a frame is to be reached by the next one (`Episode.action_until_next`): commands go there evenly from those before.

    Args:
        cell: is reset to `start` first.
        start: garment and arms before the first command.
        policy: sees joints, openness and the positions of `keypoints` (k,) vertices.
        garment: its name, one of those the policy knows.
        keypoints: vertex indices, as in the dataset.
        driving: rate and blending of chunks.
        duration_s: simulated time.

    Yields:
        The garment in every cell frame, (v, 3), the start first.
    """

    def predict(observation: np.ndarray) -> np.ndarray:
        return policy.predict(observation[None, :14], observation[None, 14:], garment)[0]

    cell.reset(start.garment_m, start.joints_rad, start.openness)
    execution = ChunkExecution(predict, driving.replan_frames, driving.decay)
    yield np.array(cell.garment_m)
    before = observe(cell, keypoints)[:14]
    for _ in range(int(duration_s * driving.rate_hz)):
        until = execution.command(observe(cell, keypoints))
        for step in range(1, driving.stride + 1):
            command = (before + (until - before) * step / driving.stride).reshape(2, 7)
            cell.step(command[:, :6], np.clip(command[:, 6], 0.0, 1.0))
            yield np.array(cell.garment_m)
        before = until


def observe(cell: Cell, keypoints: np.ndarray) -> np.ndarray:
    """Observation (14 + 3 k,): joints and openness arm by arm, then keypoint positions, as in the dataset."""
    state = np.concatenate([cell.joints_rad, np.asarray(cell.openness)[:, None]], axis=1).ravel()
    return np.concatenate([state, np.asarray(cell.garment_m)[keypoints].ravel()])
