"""Interactions that lie where they are wanted, joined by generated transitions and turned into joint commands.

Who takes the commands is another matter: the simulated cell (`sim1.motion.assembly`) or a plan (`sim1.motion.planning`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from sim1.episode import RATE_HZ
from sim1.motion.commands import FREE, Arms
from sim1.motion.model import MotionModel, sliced, transition
from sim1.motion.placement import planar, random_placement
from sim1.motion.pool import Segment, by_demo
from sim1.motion.poses import ToolPath, joined
from sim1.motion.transitions import coming, recent
from sim1.robot.kinematics import Unreachable

BRIDGE_STEPS = 5  # of MimicGen's straight line to a slice
TRANSITION_TRIALS = 4  # samples of one transition before the attempt is given up


class Refused(RuntimeError):
    """The plan cannot be carried out; `failure` is the class of the failure."""

    def __init__(self, failure: str, detail: str) -> None:
        super().__init__(detail)
        self.failure = failure


@dataclass(frozen=True, kw_only=True)
class Variation:
    """How much an attempt differs from its sources."""

    radius_m: float
    angle_rad: float
    grasp_offset_m: float  # above 0: interactions are displaced on purpose, for negative examples
    settle_s: float


@dataclass(frozen=True, kw_only=True)
class Draw:
    """What is random about an attempt before its transitions."""

    picked: list[Segment]  # interactions in the order of the task
    placement: np.ndarray  # (4, 4) of the garment, against where it lay in the demonstrations
    offset: np.ndarray  # (4, 4) displacement of the interactions on purpose


@dataclass(frozen=True, kw_only=True)
class Laid:
    """An interaction where it is to happen."""

    placement: np.ndarray  # (4, 4) from where it was demonstrated: motion of the garment since then, and displacement
    path: ToolPath  # in reach
    joints_rad: np.ndarray | None = None  # (n, 2, 6) that follow it, where they are known


class Taker(Protocol):
    """Takes commands: `kind` is that of the segment that they belong to."""

    def run(self, joints_rad: np.ndarray, path: ToolPath, kind: str) -> None: ...


def skeleton(segments: list[Segment], rng: np.random.Generator) -> list[Segment]:
    """Interactions in the order of the task, each from a random successful demonstration with as many of them.

    Raises:
        ValueError: no successful demonstration has an interaction.
    """
    interactions = {
        demo: [part for part in parts if part.kind == "interacting"]
        for demo, parts in by_demo(segments).items()
        if parts[0].success
    }
    usable = [demo for demo, parts in interactions.items() if parts]
    if not usable:
        raise ValueError("no successful demonstration with an interaction to draw from")
    length = len(interactions[usable[int(rng.integers(len(usable)))]])
    alike = [demo for demo in usable if len(interactions[demo]) == length]
    return [interactions[alike[int(rng.integers(len(alike)))]][step] for step in range(length)]


def drawn(segments: list[Segment], centre_m: np.ndarray, variation: Variation, rng: np.random.Generator) -> Draw:
    """Interactions, placement of the garment about `centre_m` (3,), displacement: in this order from `rng`."""
    picked = skeleton(segments, rng)
    placement = random_placement(rng, variation.radius_m, variation.angle_rad, centre_m)
    angle = rng.uniform(0, 2 * np.pi)
    offset = planar(variation.grasp_offset_m * np.array([np.cos(angle), np.sin(angle)]), 0.0, np.zeros(3))
    return Draw(picked=picked, placement=placement, offset=offset)


def carry_out(
    follower: Follower, segments: list[Segment], picked: list[Segment], lay: Callable[[Segment], Laid],
    end: ToolPath, model: MotionModel, settle_s: float, stream: Callable[[], np.random.Generator],
) -> None:  # fmt: skip
    """From where `follower` stands through all interactions to `end`, and a rest.

    Args:
        follower: commands the arms.
        segments: the pool, to slice from.
        picked: interactions in the order of the task.
        lay: says where an interaction is to happen, asked when its turn comes.
        end: one frame, where the path ends.
        model: makes the transitions.
        settle_s: rest at the end.
        stream: randomness of the next transition.

    Raises:
        Unreachable: a pose is out of the arms' reach.
        Refused: a joint would move too fast, or there is no motion to slice.
    """
    for part in picked:
        laid = lay(part)
        follower.go(model, laid.path, partial(_slice, segments, part, -1, laid.placement), stream())
        follower.follow(laid.path, "interacting", laid.joints_rad)
    # The way home is that of the demonstration of the last interaction; home itself has not moved.
    follower.go(model, end, partial(_slice, segments, picked[-1], 1, np.eye(4)), stream())
    if model.method != "slicing":  # a slice ends where its demonstration ended
        follower.follow(end, "moving")
    follower.rest(round(settle_s * RATE_HZ))


class Follower:
    """Turns tool paths into commands, from where the last one ended."""

    def __init__(self, arms: Arms, taker: Taker, joints_rad: np.ndarray, openness: np.ndarray) -> None:
        self.arms, self.taker, self.joints_rad = arms, taker, joints_rad
        self.trace = arms.tool_path(joints_rad[None], openness[None])  # frames commanded last
        self.speed_share = 0.0

    def go(self, model: MotionModel, target: ToolPath, slice_from: Callable[[ToolPath, int], ToolPath], rng: np.random.Generator) -> None:  # fmt: skip
        """Move to the first frame of `target`, which itself is not commanded yet."""
        history, start = recent(self.trace), self.trace[-1:]
        steps = (
            BRIDGE_STEPS if model.method == "slicing" else model.durations.sample_steps(history, coming(target), rng)
        )
        for trial in range(TRANSITION_TRIALS):
            if model.method == "slicing":
                path = slice_from(start, steps)[1:]
            else:
                path = transition(model, history, coming(target), steps, rng)[1:-1]
            try:
                joints = self.arms.joints_for(path, self.joints_rad, FREE)
            except Unreachable:
                if trial + 1 == TRANSITION_TRIALS:
                    raise
                continue  # another sample may stay within reach
            share = self.arms.speed_share(joints, self.joints_rad)
            if share <= 1:
                break
            steps = int(np.ceil(1.05 * share * steps))  # what asks too much of a joint is given more time
        self._run(path, joints, share, "moving")

    def follow(self, path: ToolPath, kind: str, joints_rad: np.ndarray | None = None) -> None:
        """Command a path as it is, with the joints that are known to follow it if the arms can go on with them."""
        joints = joints_rad
        if joints is None or self.arms.speed_share(joints[:1], self.joints_rad) > 1:
            joints = self.arms.joints_for(path, self.joints_rad)
        self._run(path, joints, self.arms.speed_share(joints, self.joints_rad), kind)

    def rest(self, frames: int) -> None:
        """Keep still."""
        if frames == 0:
            return
        last = self.trace[-1:]
        self._run(joined(*[last] * frames), np.repeat(self.joints_rad[None], frames, axis=0), 0.0, "moving")

    def _run(self, path: ToolPath, joints: np.ndarray, share: float, kind: str) -> None:
        self.speed_share = max(self.speed_share, share)
        if share > 1:
            raise Refused("too fast", f"a joint would move at {share:.2f} times its speed limit")
        self.taker.run(joints, path, kind)
        self.joints_rad = joints[-1]
        self.trace = recent(joined(self.trace, path))


def _slice(segments: list[Segment], part: Segment, offset: int, placement: np.ndarray, start: ToolPath, steps: int) -> ToolPath:  # fmt: skip
    """The motion beside `part` in its own demonstration, before it (offset -1) or after it (1), moved by `placement`."""
    parts = by_demo(segments)[part.demo]
    index = next(i for i, item in enumerate(parts) if item.segment == part.segment) + offset
    if not 0 <= index < len(parts) or parts[index].kind != "moving":
        raise Refused("no source motion", "the source has no motion to slice there")
    return sliced(parts[index].path, placement, start, steps)
