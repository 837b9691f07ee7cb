"""Behaviour cloning of the state policy, and its error on trajectories that it has not seen."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import torch
from numpy.lib.stride_tricks import sliding_window_view
from torch.nn import functional

from sim1.policy.episodes import Trajectory
from sim1.policy.model import ChunkPolicy, PolicyShape

OPENNESS = [6, 13]  # places of the gripper openness in state and action
JOINTS = [place for place in range(14) if place not in OPENNESS]


@dataclass(frozen=True, kw_only=True)
class TrainingPlan:
    """How a model is fitted."""

    steps: int
    batch: int
    learning_rate: float
    input_noise: float  # standard deviation, in units of each input's spread
    chunk_frames: int
    width: int
    depth: int


def chunks_of(action: np.ndarray, chunk_frames: int) -> np.ndarray:
    """Commands of the current and the next frames, (T, chunk_frames, a); the last command is held at the end."""
    held = np.concatenate([action, np.repeat(action[-1:], chunk_frames - 1, axis=0)])
    return np.moveaxis(sliding_window_view(held, chunk_frames, axis=0), -1, 1)


def train(trajectories: Sequence[Trajectory], garments: Sequence[str], plan: TrainingPlan, seed: int) -> ChunkPolicy:
    """Fit a policy to `trajectories`; the same seed gives the same weights on one machine.

    `garments` are all that the policy is to know, also those that happen to have no trajectory in a small set.
    """
    inputs = np.concatenate([np.concatenate([item.state, item.keypoints], axis=1) for item in trajectories])
    chunks = np.concatenate([chunks_of(item.action, plan.chunk_frames) for item in trajectories])
    garment = np.concatenate([np.full(len(item.state), garments.index(item.garment)) for item in trajectories])
    shape = PolicyShape(
        garments=tuple(garments),
        state_size=trajectories[0].state.shape[1],
        keypoint_size=trajectories[0].keypoints.shape[1],
        action_size=trajectories[0].action.shape[1],
        chunk_frames=plan.chunk_frames,
        width=plan.width,
        depth=plan.depth,
    )
    with one_thread(), torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        policy = ChunkPolicy(shape)
        policy.set_normalisation(inputs, np.concatenate([item.action for item in trajectories]))
        one_hot = functional.one_hot(torch.from_numpy(garment), len(garments)).float()
        data = (torch.from_numpy(inputs), torch.from_numpy(chunks), one_hot)
        _fit(policy, data, plan)
    return policy.eval()


def _fit(policy: ChunkPolicy, data: tuple[torch.Tensor, torch.Tensor, torch.Tensor], plan: TrainingPlan) -> None:
    inputs, chunks, one_hot = data
    optimiser = torch.optim.AdamW(policy.parameters(), lr=plan.learning_rate, weight_decay=1e-4)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, plan.steps)
    for _ in range(plan.steps):
        pick = torch.randint(len(inputs), (plan.batch,))
        # Noise on what the policy sees teaches it to come back to the demonstrated path.
        seen = inputs[pick] + plan.input_noise * policy.input_std * torch.randn(plan.batch, inputs.shape[1])
        loss = functional.l1_loss(policy(seen, one_hot[pick]), policy.normalise_action(chunks[pick]))
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()


@dataclass(frozen=True, kw_only=True)
class OpenLoopError:
    """Mean absolute error over all frames and commands of a chunk."""

    joint_error_rad: float
    openness_error: float
    hold_joint_error_rad: float  # of a policy that commands the arms to stay where they are
    hold_openness_error: float


def open_loop_error(policy: ChunkPolicy, trajectory: Trajectory) -> OpenLoopError:
    """How far the predicted chunks are from the recorded commands, given the recorded observations."""
    with one_thread():
        said = policy.predict(trajectory.state, trajectory.keypoints, trajectory.garment)
    return chunk_error(said, trajectory)


def chunk_error(said: np.ndarray, trajectory: Trajectory, every: int = 1) -> OpenLoopError:
    """How far chunks (n, chunk_frames, 14) are from the recorded commands; they answer to every `every`-th frame."""
    truth = chunks_of(trajectory.action, said.shape[1])[::every]
    error, hold = np.abs(said - truth), np.abs(trajectory.state[::every, None, :] - truth)
    return OpenLoopError(
        joint_error_rad=float(error[..., JOINTS].mean()),
        openness_error=float(error[..., OPENNESS].mean()),
        hold_joint_error_rad=float(hold[..., JOINTS].mean()),
        hold_openness_error=float(hold[..., OPENNESS].mean()),
    )


@contextmanager
def one_thread() -> Iterator[None]:
    """Sums in one order: the bytes do not depend on the number of cores (and tiny layers gain nothing from more)."""
    count = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(count)
