"""Algorithm 1 of the paper: interaction segments picked at random, joined by generated transitions, run in simulation.

Execution is closed-loop at one point: before every interaction the placement of the garment as it lies now, against how it
lay in the source demonstration, moves the segment's poses, so that grasps follow the garment.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from sim1.episode import RATE_HZ, Episode
from sim1.motion.commands import Arms
from sim1.motion.home import Home
from sim1.motion.joining import Follower, Laid, Refused, Variation, carry_out, drawn
from sim1.motion.model import MotionModel
from sim1.motion.placement import fitted_placement, grasp_weight
from sim1.motion.pool import Segment
from sim1.motion.poses import ToolPath
from sim1.motion.reaching import reachable
from sim1.robot.kinematics import Unreachable

GRASP_REACH_M = 0.10  # how far around a grasp the garment decides where the grasp has moved to


class Cell(Protocol):
    """What this room needs of the simulated cell (`sim1.cloth.cell.Cell`)."""

    garment_m: np.ndarray
    joints_rad: np.ndarray
    openness: np.ndarray

    def reset(self, garment_m: np.ndarray, joints_rad: np.ndarray, openness: np.ndarray) -> None: ...

    def step(self, joints_rad: np.ndarray, openness: np.ndarray) -> None: ...


@dataclass(frozen=True, kw_only=True)
class Source:
    """What the demonstrations give beside their segments."""

    home: Home
    garment_m: dict[tuple[str, int], np.ndarray]  # demonstration and frame in which an interaction starts -> (v, 3)
    cell: Any = None  # sim1.cloth.cell.CellConfig of the demonstrations


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

    def run(self, joints_rad: np.ndarray, path: ToolPath, kind: str) -> None:
        for joints, opened in zip(joints_rad, path.openness, strict=True):
            self._note(joints, opened)
            self.cell.step(joints, opened)

    def _note(self, joints: np.ndarray, opened: np.ndarray) -> None:
        self.joints.append(np.array(self.cell.joints_rad))
        self.openness.append(np.array(self.cell.openness))
        self.command_joints.append(np.array(joints))
        self.command_openness.append(np.array(opened))
        self.garment.append(np.array(self.cell.garment_m, np.float32))

    def episode(self, *, broke: bool) -> Episode | None:
        if not self.joints:
            return None
        if not broke:  # the state that the last command led to; behind a break there is none to which a replay gets
            self._note(self.command_joints[-1], self.command_openness[-1])
        return Episode(
            time_s=np.arange(len(self.joints)) / RATE_HZ,
            joints_rad=np.stack(self.joints),
            openness=np.stack(self.openness),
            command_joints_rad=np.stack(self.command_joints),
            command_openness=np.stack(self.command_openness),
            garment_m=np.stack(self.garment),
        )


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
    home = source.home
    draw = drawn(segments, home.start_m.mean(axis=0), variation, rng)
    placement = draw.placement
    cell.reset(home.start_m @ placement[:3, :3].T + placement[:3, 3], home.joints_rad, home.openness)
    recorder = _Recorder(cell)
    follower = Follower(arms, recorder, home.joints_rad, home.first_openness)
    sources: list[dict[str, Any]] = []

    def lay(part: Segment) -> Laid:
        before = source.garment_m[part.demo, part.start_frame]
        weight = grasp_weight(before, part.grasps, GRASP_REACH_M)
        wanted = draw.offset @ fitted_placement(before, np.asarray(cell.garment_m, float), weight)
        target, (turn_share, lean), _ = reachable(part.path, wanted, arms, part.joints_rad[0])
        about = {"segment": part.segment, "demo": part.demo, "order": part.order}
        sources.append(about | {"turn_share": turn_share, "lean_rad": lean})
        return Laid(placement=wanted, path=target)

    failure, detail, broke = None, "", False
    try:
        end = arms.tool_path(home.joints_rad[None], home.openness[None])
        carry_out(follower, segments, draw.picked, lay, end, model, variation.settle_s, lambda: rng)
    except Unreachable as error:
        failure, detail = "unreachable", str(error)
    except Refused as error:
        failure, detail = error.failure, str(error)
    except broken as error:
        failure, detail, broke = "simulation broke", str(error), True
    return Attempt(
        episode=recorder.episode(broke=broke), sources=sources, failure=failure, detail=detail, placement=placement,
        speed_share=follower.speed_share,
    )  # fmt: skip
