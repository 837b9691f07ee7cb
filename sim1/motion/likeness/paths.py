"""The paths that are compared: those of the demonstrations, and those planned from them by every method."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sim1.motion.commands import Arms
from sim1.motion.home import Home
from sim1.motion.joining import Variation, drawn
from sim1.motion.likeness.comparison import Paths
from sim1.motion.likeness.features import Movement
from sim1.motion.model import MotionModel
from sim1.motion.planning import NoPlan, Plan, laid_as_placed, planned
from sim1.motion.pool import Segment, by_demo
from sim1.motion.transitions import transitions_of
from sim1.progress import report
from sim1.stage import random_stream

if TYPE_CHECKING:
    from sim1.motion.stage import MotionLikenessConfig

METHODS = ("diffusion", "straight", "minimum_jerk", "slicing")
BASELINES = ("minimum_jerk", "slicing")  # planned beside whatever model is in force


@dataclass(frozen=True, kw_only=True)
class Planned:
    """Paths of one method, and what came of the draws that gave none."""

    plans: list[Plan]
    refused: list[NoPlan]

    def counts(self) -> dict[str, Any]:
        """How many there are, and why others are not."""
        reasons = Counter(made.failure for made in self.refused)
        fastest = max((plan.speed_share for plan in self.plans), default=0.0)
        return {"planned": len(self.plans), "refused": dict(sorted(reasons.items())), "fastest_joint_share": fastest}


def demonstrated(segments: list[Segment]) -> Paths:
    """The successful demonstrations as commanded, which are those that plans draw from."""
    demos = by_demo([part for part in segments if part.success])
    return _paths(demos, {name: frozenset({name}) for name in demos})


def planned_paths(plans: list[Plan]) -> Paths:
    """Plans in the form of demonstrations."""
    parts = {f"{index:04d}": plan.segments(f"{index:04d}") for index, plan in enumerate(plans)}
    return _paths(parts, {name: frozenset(plan.demos) for name, plan in zip(parts, plans, strict=True)})


def make_plans(
    methods: dict[str, MotionModel], segments: list[Segment], home: Home, arms: Arms, garment: str,
    config: MotionLikenessConfig, *, moved: bool,
) -> dict[str, Planned]:  # fmt: skip
    """Plans by every method from the same draws; a draw out of the arms' reach is replaced by the next one."""
    count = config.moved_count if moved else config.path_count
    variation = Variation(
        radius_m=config.radius_m if moved else 0.0,
        angle_rad=float(np.radians(config.angle_deg)) if moved else 0.0,
        grasp_offset_m=0.0,
        settle_s=config.settle_s,
    )
    result = {name: Planned(plans=[], refused=[]) for name in methods}
    for number in range(config.tries_per_path * count):
        missing = {name: model for name, model in methods.items() if len(result[name].plans) < count}
        if not missing:
            break
        report(min(len(made.plans) for made in result.values()), count, "planning paths")
        names = (config.seed, garment, "likeness", int(moved), number)
        draw = drawn(segments, home.start_m.mean(axis=0), variation, random_stream(*names))
        lay = laid_as_placed(draw, arms)
        for name, model in missing.items():
            streams = (random_stream(*names, "transition", index) for index in range(len(draw.picked) + 1))
            made = planned(segments, home, draw, lay, model, arms, config.settle_s, streams.__next__)
            if isinstance(made, Plan):
                result[name].plans.append(made)
            else:
                result[name].refused.append(made)
    return result


def by_method(model: MotionModel) -> dict[str, MotionModel]:
    """The model as it is, and the baselines with its durations."""
    return {name: replace(model, method=name) for name in METHODS if name in (model.method, *BASELINES)}


def _paths(demos: dict[str, list[Segment]], sources: dict[str, frozenset[str]]) -> Paths:
    flat = [part for parts in demos.values() for part in parts]
    return Paths(
        tools=[np.concatenate([part.path.position_m for part in parts]) for parts in demos.values()],
        joints=[np.concatenate([part.joints_rad for part in parts]) for parts in demos.values()],
        joins=[[part.start_frame - parts[0].start_frame for part in parts[1:]] for parts in demos.values()],
        movements=[
            Movement(path=item.path, order=item.order, sources=sources[item.demo]) for item in transitions_of(flat)
        ],
    )
