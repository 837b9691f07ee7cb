"""Whole tool paths planned without simulation: the garment is taken to lie exactly where it was placed.

The same draws, transitions, inverse kinematics and limits as in `sim1.motion.assembly`; no cell runs. What the cloth would do
in the fingers is not asked.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from sim1.motion.commands import Arms
from sim1.motion.home import Home
from sim1.motion.joining import Draw, Follower, Laid, Refused, carry_out
from sim1.motion.model import MotionModel
from sim1.motion.pool import Segment
from sim1.motion.poses import ToolPath
from sim1.motion.reaching import reachable
from sim1.motion.segments import Span
from sim1.robot.kinematics import Unreachable


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A planned path from home to home, T frames at 30 Hz."""

    joints_rad: np.ndarray  # (T, 2, 6)
    path: ToolPath  # (T) where the joints have the tools: at a joint's limit beside what was asked for
    spans: list[Span]  # alternating, every frame once; `moving` ones are the generated transitions
    demos: list[str]  # source of each interaction, in order
    speed_share: float  # fastest joint over its limit

    @property
    def joins(self) -> list[int]:
        """First frame of every span but the first: there two parts meet."""
        return [after.start for _, after in pairwise(self.spans)]

    def segments(self, name: str) -> list[Segment]:
        """The parts as if they had been cut from a demonstration `name`; grasps are not known."""
        result: list[Segment] = []
        for number, span in enumerate(self.spans):
            frames = slice(span.start, span.end)
            order = sum(before.kind == span.kind for before in self.spans[:number])
            result.append(
                Segment(
                    segment=number, demo=name, kind=span.kind, order=order, start_frame=span.start, end_frame=span.end,
                    grasp_left=-1, grasp_right=-1, success=True, garment="", joints_rad=self.joints_rad[frames],
                    path=self.path[frames],
                )
            )  # fmt: skip
        return result


@dataclass(frozen=True, kw_only=True)
class NoPlan:
    """The draw cannot be carried out."""

    failure: str  # unreachable, too fast, no source motion
    detail: str


@dataclass
class _Sheet:
    """Commands as they come, with the kind of each frame."""

    joints: list[np.ndarray] = field(default_factory=list)
    openness: list[np.ndarray] = field(default_factory=list)
    kinds: list[str] = field(default_factory=list)

    def run(self, joints_rad: np.ndarray, path: ToolPath, kind: str) -> None:
        self.joints.append(joints_rad)
        self.openness.append(path.openness)
        self.kinds += [kind] * len(path)


def laid_as_placed(draw: Draw, arms: Arms) -> Callable[[Segment], Laid]:
    """Where each interaction of `draw` happens, reached once however often it is asked for."""
    known: dict[int, Laid] = {}
    wanted = draw.offset @ draw.placement

    def lay(part: Segment) -> Laid:
        if part.segment not in known:
            path, _, joints = reachable(part.path, wanted, arms, part.joints_rad[0])
            known[part.segment] = Laid(placement=wanted, path=path, joints_rad=joints)
        return known[part.segment]

    return lay


def planned(
    segments: list[Segment], home: Home, draw: Draw, lay: Callable[[Segment], Laid], model: MotionModel, arms: Arms,
    settle_s: float, stream: Callable[[], np.random.Generator],
) -> Plan | NoPlan:  # fmt: skip
    """Carry out a draw on paper.

    Args:
        segments: the pool.
        home: where the arms start and end.
        draw: interactions and placement.
        lay: of `laid_as_placed`, which plans of the same draw may share.
        model: makes the transitions.
        arms: kinematics.
        settle_s: rest at the end.
        stream: randomness of the next transition.
    """
    sheet = _Sheet()
    follower = Follower(arms, sheet, home.joints_rad, home.first_openness)
    end = arms.tool_path(home.joints_rad[None], home.openness[None])
    try:
        carry_out(follower, segments, draw.picked, lay, end, model, settle_s, stream)
    except Unreachable as error:
        return NoPlan(failure="unreachable", detail=str(error))
    except Refused as error:
        return NoPlan(failure=error.failure, detail=str(error))
    joints_rad, openness = np.concatenate(sheet.joints), np.concatenate(sheet.openness)
    return Plan(
        joints_rad=joints_rad, path=arms.tool_path(joints_rad, openness), spans=_spans(sheet.kinds),
        demos=[part.demo for part in draw.picked], speed_share=follower.speed_share,
    )  # fmt: skip


def _spans(kinds: list[str]) -> list[Span]:
    bounds = [0, *[i for i in range(1, len(kinds)) if kinds[i] != kinds[i - 1]], len(kinds)]
    return [Span(kind=kinds[start], start=start, end=end) for start, end in pairwise(bounds)]
