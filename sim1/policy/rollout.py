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


class Pilot(Protocol):
    """What drives: it may see every policy frame, and is asked for a chunk in some of them, after it has seen that one."""

    def see(self, cell: Cell) -> None: ...
    def plan(self) -> np.ndarray: ...  # chunk (chunk_frames, 14), first row for the frame that was seen last


class StatePilot:
    """A state policy: sees joints, openness and the positions of `keypoints` (k,) vertices, indices as in the dataset.

    `garment` is one of those that the policy knows.
    """

    def __init__(self, policy: ChunkPolicy, garment: str, keypoints: np.ndarray) -> None:
        self._policy, self._garment, self._keypoints = policy, garment, keypoints

    def see(self, cell: Cell) -> None:
        self._observation = observe(cell, self._keypoints)

    def plan(self) -> np.ndarray:
        state, keypoints = self._observation[None, :14], self._observation[None, 14:]
        return self._policy.predict(state, keypoints, self._garment)[0]


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

    def frame_count(self, duration_s: float) -> int:
        """Policy frames of a rollout."""
        return int(duration_s * self.rate_hz)


def roll_out(cell: Cell, start: Start, pilot: Pilot, driving: Driving, duration_s: float) -> Iterator[np.ndarray]:
    """Let a pilot drive for `duration_s`; what came before a cell broke is known, too.

    What it says in a frame is to be reached by the next one (`Episode.action_until_next`): commands go there evenly from those before.

    Args:
        cell: is reset to `start` first.
        start: garment and arms before the first command.
        pilot: sees every policy frame.
        driving: rate and blending of chunks.
        duration_s: simulated time.

    Yields:
        The garment in every cell frame, (v, 3), the start first.
    """
    cell.reset(start.garment_m, start.joints_rad, start.openness)
    execution = ChunkExecution(pilot.plan, driving.replan_frames, driving.decay)
    yield np.array(cell.garment_m)
    before = arm_state(cell)
    for _ in range(driving.frame_count(duration_s)):
        pilot.see(cell)
        until = execution.command()
        for step in range(1, driving.stride + 1):
            command = (before + (until - before) * step / driving.stride).reshape(2, 7)
            cell.step(command[:, :6], np.clip(command[:, 6], 0.0, 1.0))
            yield np.array(cell.garment_m)
        before = until


def arm_state(cell: Cell) -> np.ndarray:
    """Joints and openness arm by arm, (14,), as in the dataset."""
    return np.concatenate([cell.joints_rad, np.asarray(cell.openness)[:, None]], axis=1).ravel()


def observe(cell: Cell, keypoints: np.ndarray) -> np.ndarray:
    """Observation (14 + 3 k,): `arm_state`, then keypoint positions, as in the dataset."""
    return np.concatenate([arm_state(cell), np.asarray(cell.garment_m)[keypoints].ravel()])
