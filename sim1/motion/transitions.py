"""Demonstrated transitions as training examples, enlarged by rigid motions, mirroring and cutting of windows."""

from dataclasses import dataclass

import numpy as np

from sim1.motion.placement import planar
from sim1.motion.pool import Segment, by_demo
from sim1.motion.poses import TOKEN_SIZE, ToolPath, joined, to_tokens
from sim1.motion.residual import residual_of

HISTORY_COUNT = 4  # frames before the transition that the model sees
REST_M = 2e-4  # travel of a frame step below which a tool rests: 6 mm/s
MINIMUM_FRAMES = 6  # a shorter transition has no shape to learn


@dataclass(frozen=True, kw_only=True)
class Transition:
    """A motion between two interactions, boundary poses included, with the frames before it."""

    demo: str
    history: ToolPath  # (HISTORY_COUNT), the last frame is the start pose
    path: ToolPath  # (n)


@dataclass(frozen=True, kw_only=True)
class Bank:
    """Training examples: b transitions at n even phases."""

    residual: np.ndarray  # (b, n, 20) zero at both ends
    base: np.ndarray  # (b, n, 20) interpolant
    history: np.ndarray  # (b, HISTORY_COUNT, 20)
    steps: np.ndarray  # (b,) frame steps that the transition takes


def transitions_of(segments: list[Segment]) -> list[Transition]:
    """Every `moving` segment with the boundary frames of its neighbours, long enough to learn from."""
    result = []
    for demo, parts in by_demo(segments).items():
        for index, part in enumerate(parts):
            if part.kind != "moving":
                continue
            before = parts[index - 1].path if index else part.path[:1]
            after = [parts[index + 1].path[:1]] if index + 1 < len(parts) else []
            whole = joined(before[-1:], part.path, *after)
            start, end = moving_frames(whole)
            path, before = whole[start:end], joined(before, whole[1 : start + 1])
            if len(path) >= MINIMUM_FRAMES:
                result.append(Transition(demo=demo, history=recent(before), path=path))
    return result


def moving_frames(path: ToolPath) -> tuple[int, int]:
    """First and last frame (excluded) of the motion in `path`: waiting at its ends is no part of a transition."""
    steps = np.linalg.norm(np.diff(path.position_m, axis=0), axis=-1).max(axis=1)
    moving = np.flatnonzero(steps > REST_M)
    return (int(moving[0]), int(moving[-1]) + 2) if len(moving) else (0, 1)


def recent(path: ToolPath) -> ToolPath:
    """The last HISTORY_COUNT frames; a short path is taken to have rested at its first pose."""
    return path[np.maximum(np.arange(len(path) - HISTORY_COUNT, len(path)), 0)]


def augmented(transition: Transition, rng: np.random.Generator) -> Transition:
    """A random variation: moved on the table by up to 10 cm and 30 degrees, mirrored, cut to a window."""
    history, path = transition.history, transition.path
    centre = path.position_m.mean(axis=(0, 1))
    motion = planar(rng.uniform(-0.1, 0.1, 2), rng.uniform(-np.pi / 6, np.pi / 6), centre)
    history, path = history.moved(motion), path.moved(motion)
    if rng.uniform() < 0.5:
        history, path = history.mirrored(), path.mirrored()
    if rng.uniform() < 0.5 and len(path) >= 2 * MINIMUM_FRAMES:
        length = int(rng.integers(max(MINIMUM_FRAMES, len(path) // 2), len(path) + 1))
        start = int(rng.integers(0, len(path) - length + 1))
        history = recent(joined(history[:-1], path[: start + 1]))
        path = path[start : start + length]
    return Transition(demo=transition.demo, history=history, path=path)


def bank_of(transitions: list[Transition], count: int, token_count: int, rng: np.random.Generator) -> Bank:
    """`count` random variations of `transitions`, as arrays."""
    residuals, bases, histories, steps = [], [], [], []
    for _ in range(count):
        example = augmented(transitions[int(rng.integers(len(transitions)))], rng)
        residual, base, _, _ = residual_of(example.path, token_count)
        residuals.append(residual)
        bases.append(to_tokens(base))
        histories.append(to_tokens(example.history))
        steps.append(len(example.path) - 1)
    return Bank(
        residual=np.stack(residuals), base=np.stack(bases), history=np.stack(histories), steps=np.array(steps, float)
    )


def residual_scale(residual: np.ndarray) -> np.ndarray:
    """(20,) standard deviation of every channel away from the ends, with a floor of a fiftieth of the largest."""
    spread = residual[:, 1:-1].reshape(-1, TOKEN_SIZE).std(axis=0)
    return np.maximum(spread, max(spread.max() / 50, 1e-4))
