"""Demonstrated transitions as training examples, enlarged by mirroring, cutting of windows and ends that lie elsewhere."""

from dataclasses import dataclass, replace

import numpy as np

from sim1.motion.interpolant import ENDS, interpolate
from sim1.motion.placement import planar, random_placement
from sim1.motion.pool import Segment, by_demo
from sim1.motion.poses import TOKEN_SIZE, ToolPath, joined, to_tokens
from sim1.motion.residual import residual_of

HISTORY_COUNT = 4  # frames before the transition that the model sees
REST_M = 2e-4  # travel of a frame step below which a tool rests: 6 mm/s
HEADING_M = 0.01  # tools that hardly travel have no heading
ELSEWHERE_M, ELSEWHERE_RAD = 0.06, 0.3  # how far ends are displaced: a little more than candidates place the garment
MINIMUM_FRAMES = 6  # a shorter transition has no shape to learn


@dataclass(frozen=True, kw_only=True)
class Transition:
    """A motion between two interactions, boundary poses included, with the frames on either side of it."""

    demo: str
    order: int  # how many motions come before it in its demonstration
    history: ToolPath  # (HISTORY_COUNT), the last frame is the start pose
    path: ToolPath  # (n)
    after: ToolPath  # (ENDS), the first frame is the end pose


@dataclass(frozen=True, kw_only=True)
class Bank:
    """Training examples: b transitions at n even phases."""

    residual: np.ndarray  # (b, n, 20) zero at both ends
    base: np.ndarray  # (b, n, 20) interpolant
    history: np.ndarray  # (b, HISTORY_COUNT, 20)
    after: np.ndarray  # (b, ENDS, 20)
    steps: np.ndarray  # (b,) frame steps that the transition takes


def transitions_of(segments: list[Segment]) -> list[Transition]:
    """Every `moving` segment with the boundary frames of its neighbours, long enough to learn from."""
    result = []
    for demo, parts in by_demo(segments).items():
        for index, part in enumerate(parts):
            if part.kind != "moving":
                continue
            before = parts[index - 1].path if index else part.path[:1]
            rest = parts[index + 1].path if index + 1 < len(parts) else part.path[:0]
            whole = joined(before[-1:], part.path, rest[:ENDS])
            start, end = moving_frames(whole[: len(part.path) + 1 + min(len(rest), 1)])
            path = whole[start:end]
            if len(path) >= MINIMUM_FRAMES:
                history = recent(joined(before, whole[1 : start + 1]))
                after = coming(whole[end - 1 :])
                result.append(Transition(demo=demo, order=part.order, history=history, path=path, after=after))
    return result


def moving_frames(path: ToolPath) -> tuple[int, int]:
    """First and last frame (excluded) of the motion in `path`: waiting at its ends is no part of a transition.

    One frame more on either side: a smooth motion leaves rest and comes to rest in a step that is too small to see.
    """
    steps = np.linalg.norm(np.diff(path.position_m, axis=0), axis=-1).max(axis=1)
    moving = np.flatnonzero(steps > REST_M)
    if not len(moving):
        return 0, 1
    return max(int(moving[0]) - 1, 0), min(int(moving[-1]) + 3, len(path))


def recent(path: ToolPath) -> ToolPath:
    """The last HISTORY_COUNT frames; a short path is taken to have rested at its first pose."""
    return path[np.maximum(np.arange(len(path) - HISTORY_COUNT, len(path)), 0)]


def coming(path: ToolPath) -> ToolPath:
    """The first ENDS frames; a short path is taken to rest at its last pose."""
    return path[np.minimum(np.arange(ENDS), len(path) - 1)]


def augmented(transition: Transition, rng: np.random.Generator) -> Transition:
    """A random variation: mirrored or not, whole or cut to a window."""
    history, path, after = transition.history, transition.path, transition.after
    if rng.uniform() < 0.5:
        history, path, after = (part.mirrored() for part in (history, path, after))
    if rng.uniform() < 0.5 and len(path) >= 2 * MINIMUM_FRAMES:
        length = int(rng.integers(max(MINIMUM_FRAMES, len(path) // 2), len(path) + 1))
        start = int(rng.integers(0, len(path) - length + 1))
        history = recent(joined(history[:-1], path[: start + 1]))
        after = coming(joined(path[start + length - 1 : -1], after))
        path = path[start : start + length]
    return replace(transition, history=history, path=path, after=after)


def outlook(start: ToolPath, end: ToolPath) -> np.ndarray:
    """(4, 4) of the table's frame as the tools see it between two poses: origin midway, x from where they are to where they go.

    What is learned in it holds anywhere on the table.
    """
    here, there = start.position_m[0].mean(axis=0), end.position_m[0].mean(axis=0)
    way = (there - here)[:2]
    angle = np.arctan2(way[1], way[0]) if np.linalg.norm(way) > HEADING_M else 0.0
    return planar((here + there)[:2] / 2, angle, np.zeros(3))


def bank_of(transitions: list[Transition], count: int, token_count: int, rng: np.random.Generator) -> Bank:
    """`count` random variations of `transitions` as arrays, each in its own outlook.

    Half of them are shown with an end that lies elsewhere, since a garment that was moved asks for other ways of the same kind.
    """
    residuals, bases, histories, afters, steps = [], [], [], [], []
    phase = np.linspace(0, 1, token_count)
    for _ in range(count):
        example = augmented(transitions[int(rng.integers(len(transitions)))], rng)
        length = len(example.path) - 1
        back = np.linalg.inv(outlook(example.path[:1], example.path[-1:]))
        history, path, after = (part.moved(back) for part in (example.history, example.path, example.after))
        residual, base = residual_of(history[-ENDS:], path, after, token_count)
        if rng.uniform() < 0.5:
            centre = after.position_m[0].mean(axis=0)
            after = after.moved(random_placement(rng, ELSEWHERE_M, ELSEWHERE_RAD, centre))
            back = np.linalg.inv(outlook(history[-1:], after[:1]))
            history, after = history.moved(back), after.moved(back)
            base = interpolate(history[-ENDS:], after, phase, length)
        residuals.append(residual)
        bases.append(to_tokens(base))
        histories.append(to_tokens(history))
        afters.append(to_tokens(after))
        steps.append(length)
    return Bank(
        residual=np.stack(residuals), base=np.stack(bases), history=np.stack(histories), after=np.stack(afters),
        steps=np.array(steps, float),
    )  # fmt: skip


def principal_shapes(residual: np.ndarray, scale: np.ndarray, count: int) -> np.ndarray:
    """(count, n * 20) orthonormal directions that carry most of the residuals (b, n, 20) in units of `scale` (20,)."""
    return np.linalg.svd((residual / scale).reshape(len(residual), -1), full_matrices=False)[2][:count]


def residual_scale(residual: np.ndarray) -> np.ndarray:
    """(n, 20) size of residuals (b, n, 20): of every channel, with a floor of a fiftieth of the largest, times that of every phase.

    Near its ends a residual is small, as the interpolant has the neighbours' speed and acceleration: an error of the network there
    must be small likewise, or it is heard as a jerk at the join.
    """
    inner = residual[:, 1:-1]
    spread = inner.reshape(-1, TOKEN_SIZE).std(axis=0)
    channel = np.maximum(spread, max(spread.max() / 50, 1e-4))
    phase = np.sqrt(((inner / channel) ** 2).mean(axis=(0, 2)))
    phase = np.concatenate([[1.0], np.maximum(phase, max(phase.max() / 1000, 1e-6)), [1.0]])  # ends are exact anyway
    return phase[:, None] * channel
