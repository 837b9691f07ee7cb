"""Algorithm 1 of the paper: interaction segments picked at random, joined by generated transitions, run in simulation.

Execution is closed-loop at one point: before every interaction the placement of the garment as it lies now, against how it
lay in the source demonstration, moves the segment's poses, so that grasps follow the garment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from sim1.episode import RATE_HZ, Episode
from sim1.motion.commands import Arms
from sim1.motion.model import MotionModel, sliced, transition
from sim1.motion.placement import fitted_placement, grasp_weight, planar, random_placement
from sim1.motion.pool import Segment, by_demo
from sim1.motion.poses import ToolPath, joined
from sim1.motion.reaching import reachable
from sim1.motion.transitions import recent
from sim1.robot.kinematics import Unreachable

BRIDGE_STEPS = 5  # of MimicGen's straight line to a slice
TRANSITION_TRIALS = 4  # samples of one transition before the attempt is given up
GRASP_REACH_M = 0.10  # how far around a grasp the garment decides where the grasp has moved to


class Cell(Protocol):
    """What this room needs of the simulated cell (`sim1.cloth.cell.Cell`)."""

    garment_m: np.ndarray
    joints_rad: np.ndarray
    openness: np.ndarray

    def reset(self, garment_m: np.ndarray, joints_rad: np.ndarray, openness: np.ndarray) -> None: ...

    def step(self, joints_rad: np.ndarray, openness: np.ndarray) -> None: ...


class Refused(RuntimeError):
    """The plan cannot be carried out; `failure` is the class of the failure."""

    def __init__(self, failure: str, detail: str) -> None:
        super().__init__(detail)
        self.failure = failure


@dataclass(frozen=True, kw_only=True)
class Source:
    """What the demonstrations give beside their segments."""

    start_m: np.ndarray  # (v, 3) garment settled on the table before anything moves
    garment_m: dict[str, np.ndarray]  # demo -> (T, v, 3)
    home_rad: np.ndarray  # (2, 6) joints at the start of a demonstration
    home_openness: np.ndarray  # (2,)
    cell: Any = None  # sim1.cloth.cell.CellConfig of the demonstrations


@dataclass(frozen=True, kw_only=True)
class Variation:
    """How much an attempt differs from its sources."""

    radius_m: float
    angle_rad: float
    grasp_offset_m: float  # above 0: interactions are displaced on purpose, for negative examples
    settle_s: float


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """One attempt at an episode, whatever came of it."""

    episode: Episode | None  # None where nothing ran
    sources: list[dict[str, Any]]
    failure: str | None  # unreachable, too fast, no source motion, simulation broke; None when the whole path ran
    detail: str
    placement: np.ndarray  # (4, 4)
    speed_share: float


@dataclass
class _Recorder:
    """Frames as they run: what was measured, and what was asked for then."""

    cell: Cell
    joints: list[np.ndarray] = field(default_factory=list)
    openness: list[np.ndarray] = field(default_factory=list)
    command_joints: list[np.ndarray] = field(default_factory=list)
    command_openness: list[np.ndarray] = field(default_factory=list)
    garment: list[np.ndarray] = field(default_factory=list)

    def run(self, joints_rad: np.ndarray, openness: np.ndarray) -> None:
        for joints, opened in zip(joints_rad, openness, strict=True):
            self._note(joints, opened)
            self.cell.step(joints, opened)

    def _note(self, joints: np.ndarray, opened: np.ndarray) -> None:
        self.joints.append(np.array(self.cell.joints_rad))
        self.openness.append(np.array(self.cell.openness))
        self.command_joints.append(np.array(joints))
        self.command_openness.append(np.array(opened))
        self.garment.append(np.array(self.cell.garment_m, np.float32))

    def episode(self) -> Episode | None:
        if not self.joints:
            return None
        finite = np.isfinite(self.cell.garment_m).all()
        if finite:  # the state that the last command led to
            self._note(self.command_joints[-1], self.command_openness[-1])
        return Episode(
            time_s=np.arange(len(self.joints)) / RATE_HZ,
            joints_rad=np.stack(self.joints),
            openness=np.stack(self.openness),
            command_joints_rad=np.stack(self.command_joints),
            command_openness=np.stack(self.command_openness),
            garment_m=np.stack(self.garment),
        )


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


def attempt(
    segments: list[Segment], source: Source, model: MotionModel, arms: Arms, cell: Cell, variation: Variation,
    rng: np.random.Generator, broken: type[Exception],
) -> Attempt:  # fmt: skip
    """Draw, plan and run one candidate.

    Args:
        segments: the pool.
        source: start and garments of the demonstrations.
        model: makes the transitions.
        arms: kinematics.
        cell: simulator; it is reset.
        variation: size of the random changes.
        rng: this attempt's own stream.
        broken: what the cell raises when its state is no longer physical.
    """
    picked = skeleton(segments, rng)
    centre = source.start_m.mean(axis=0)
    placement = random_placement(rng, variation.radius_m, variation.angle_rad, centre)
    offset = _offset(rng, variation.grasp_offset_m)
    cell.reset(source.start_m @ placement[:3, :3].T + placement[:3, 3], source.home_rad, source.home_openness)
    recorder = _Recorder(cell)
    follower = _Follower(arms, recorder, source.home_rad, source.home_openness)
    sources, failure, detail = [], None, ""
    try:
        for part in picked:
            before = source.garment_m[part.demo][part.start_frame]
            weight = grasp_weight(before, part.grasps, GRASP_REACH_M)
            now = fitted_placement(before, np.asarray(cell.garment_m, float), weight)
            target, (turn_share, lean) = reachable(part.path, offset @ now, arms, part.joints_rad[0])
            sources.append(
                {
                    "segment": part.segment,
                    "demo": part.demo,
                    "order": part.order,
                    "turn_share": turn_share,
                    "lean_rad": lean,
                }
            )
            follower.go(
                model, target, lambda start, steps, part=part, now=now: _slice(segments, part, now, start, steps), rng
            )
            follower.follow(target)
        home = arms.tool_path(source.home_rad[None], source.home_openness[None])
        follower.go(
            model, joined(home, home), lambda start, steps: _slice(segments, None, np.eye(4), start, steps), rng
        )
        if model.method != "slicing":  # a slice ends where its demonstration ended
            follower.follow(home[:1])
        follower.rest(round(variation.settle_s * RATE_HZ))
    except Unreachable as error:
        failure, detail = "unreachable", str(error)
    except Refused as error:
        failure, detail = error.failure, str(error)
    except broken as error:
        failure, detail = "simulation broke", str(error)
    return Attempt(
        episode=recorder.episode(), sources=sources, failure=failure, detail=detail, placement=placement,
        speed_share=follower.speed_share,
    )  # fmt: skip


class _Follower:
    """Turns tool paths into commands and runs them, from where the last one ended."""

    def __init__(self, arms: Arms, recorder: _Recorder, joints_rad: np.ndarray, openness: np.ndarray) -> None:
        self.arms, self.recorder, self.joints_rad = arms, recorder, joints_rad
        self.trace = arms.tool_path(joints_rad[None], openness[None])  # frames commanded last
        self.speed_share = 0.0

    def go(self, model: MotionModel, target: ToolPath, slice_from: Callable[[ToolPath, int], ToolPath], rng: np.random.Generator) -> None:  # fmt: skip
        """Move to the first frame of `target`, which itself is not commanded yet."""
        history, start = recent(self.trace), self.trace[-1:]
        velocity = target.position_m[1] - target.position_m[0]
        steps = BRIDGE_STEPS if model.method == "slicing" else model.durations.sample_steps(start, target[:1], rng)
        for trial in range(TRANSITION_TRIALS):
            if model.method == "slicing":
                path = slice_from(start, steps)[1:]
            else:
                path = transition(model, history, target[:1], velocity, steps, rng)[1:-1]
            try:
                joints = self.arms.joints_for(path, self.joints_rad)
            except Unreachable:
                if trial + 1 == TRANSITION_TRIALS:
                    raise
                continue  # another sample may stay within reach
            share = self.arms.speed_share(joints, self.joints_rad)
            if share <= 1:
                break
            steps = int(np.ceil(1.05 * share * steps))  # what asks too much of a joint is given more time
        self._run(path, joints, share)

    def follow(self, path: ToolPath) -> None:
        """Run a path as it is."""
        joints = self.arms.joints_for(path, self.joints_rad)
        self._run(path, joints, self.arms.speed_share(joints, self.joints_rad))

    def rest(self, frames: int) -> None:
        """Keep still."""
        if frames == 0:
            return
        last = self.trace[-1:]
        self._run(joined(*[last] * frames), np.repeat(self.joints_rad[None], frames, axis=0), 0.0)

    def _run(self, path: ToolPath, joints: np.ndarray, share: float) -> None:
        self.speed_share = max(self.speed_share, share)
        if share > 1:
            raise Refused("too fast", f"a joint would move at {share:.2f} times its speed limit")
        self.recorder.run(joints, path.openness)
        self.joints_rad = joints[-1]
        self.trace = recent(joined(self.trace, path))


def _offset(rng: np.random.Generator, size_m: float) -> np.ndarray:
    angle = rng.uniform(0, 2 * np.pi)
    return planar(size_m * np.array([np.cos(angle), np.sin(angle)]), 0.0, np.zeros(3))


def _slice(segments: list[Segment], part: Segment | None, now: np.ndarray, start: ToolPath, steps: int) -> ToolPath:
    """The demonstrated motion before `part`; before the end of the first successful demonstration where it is None."""
    demo = part.demo if part else next(item.demo for item in segments if item.success)
    parts = by_demo(segments)[demo]
    index = next(i for i, item in enumerate(parts) if part and item.segment == part.segment) if part else len(parts)
    before = parts[index - 1] if index else None
    if before is None or before.kind != "moving":
        raise Refused("no source motion", "the source has no motion to slice there")
    return sliced(before.path, now, start, steps)
