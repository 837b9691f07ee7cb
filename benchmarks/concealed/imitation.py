"""What of a change the bundle's unknowns could have made: fabric, friction, and how grips hold the cloth where nobody says.

A sheet that something pulls down a little may as well be a little heavier: nobody who is free to choose the weight can tell. What there is
to find of an effect is what is left of its change when the unknowns have taken up what they can.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.concealed.case import Plan
from benchmarks.concealed.effects.effect import Effect
from benchmarks.concealed.film import Stage, Track, film
from benchmarks.concealed.grips import Poses
from benchmarks.concealed.motions.motion import DURATION_S
from benchmarks.concealed.setting import DENSITY_STD_SHARE, FRICTION_STD, LOG_STD, POISSON_STD, Setting
from benchmarks.concealed.world import World

CHECK_TIMES_S = np.arange(0, DURATION_S, 0.01)
SHARE = 0.5
"""Of its spread that an unknown is moved by, to see what that does."""
PLACE_STD_M, PLACE_STD_RAD = 0.01, 0.05
"""How far off a grip's hold may be that nobody has measured."""

Changes = dict[str, np.ndarray]
"""By plan: (F, M, 3) changes of markers at CHECK_TIMES_S."""


@dataclass
class Misplaced(Effect):
    """One gripper holds the cloth elsewhere than the robot's pose has it."""

    name: ClassVar[str] = "misplaced"
    drive: str = ""
    shift_m: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """(3,) in the drive's frame."""
    turn_rad: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def begin(self, world: World) -> None:
        """Which of the motion's drives it is."""
        self._which = [block.drive == self.drive for block in world.motion.blocks]

    def poses(self, times_s: np.ndarray, poses: Poses) -> Poses:
        """Shift and turn it with its drive."""
        position, rotation = poses.position_m.copy(), poses.rotation.copy()
        position[:, self._which] += rotation[:, self._which] @ self.shift_m
        rotation[:, self._which] = rotation[:, self._which] @ Rotation.from_rotvec(self.turn_rad).as_matrix()
        return Poses(position, rotation)


@dataclass(frozen=True)
class Unknown:
    """Something that the bundle leaves open, moved by SHARE of its spread."""

    setting: Setting
    effects: tuple[Effect, ...]
    concerns: Callable[[Plan], bool]
    """Whether it changes a motion at all."""


def imitations(stage: Stage, plan_list: Sequence[Plan], tracks: Mapping[str, Track]) -> dict[str, np.ndarray]:
    """By plan: (F, M, 3, P) what each unknown moves the markers by, per spread; a film for each. `tracks`: with none moved."""
    without = {plan.name: seen(tracks[plan.name]) for plan in plan_list}
    columns: dict[str, list[np.ndarray]] = {plan.name: [] for plan in plan_list}
    for unknown in unknowns(stage.setting, plan_list):
        moved = replace(stage, setting=unknown.setting)
        for plan in plan_list:
            place, change = without[plan.name], np.zeros_like(without[plan.name])
            if unknown.concerns(plan):
                change = (seen(film(moved, plan, unknown.effects)) - place) / SHARE
            columns[plan.name].append(change)
    return {name: np.stack(changes, axis=-1) for name, changes in columns.items()}


def own(changes: Changes, imitated: dict[str, np.ndarray], noise_m: float) -> Changes:
    """What is left of changes when the unknowns, the same in all plans, are what priors and white noise make likeliest (ridge)."""
    tall = np.concatenate([imitated[name].reshape(-1, imitated[name].shape[-1]) for name in changes]) / noise_m
    wanted = np.concatenate([change.ravel() for change in changes.values()]) / noise_m
    taken = np.linalg.solve(tall.T @ tall + np.eye(tall.shape[1]), tall.T @ wanted)
    return {name: change - imitated[name] @ taken for name, change in changes.items()}


def unknowns(setting: Setting, plan_list: Sequence[Plan]) -> Iterator[Unknown]:
    """What the bundle of such a setting leaves open in these motions."""
    cloth = setting.cloth
    moved = {name: getattr(cloth, name) * np.exp(SHARE * std) for name, std in LOG_STD.items()}
    moved["area_density_kg_m2"] = cloth.area_density_kg_m2 * (1 + SHARE * DENSITY_STD_SHARE)
    moved["poisson"] = cloth.poisson + SHARE * POISSON_STD
    for name, value in moved.items():
        yield Unknown(replace(setting, cloth=replace(cloth, **{name: float(value)})), (), lambda plan: True)
    yield Unknown(
        replace(setting, friction=setting.friction + SHARE * FRICTION_STD), (), lambda plan: plan.motion.table
    )
    if setting.places_given:
        return
    for drive in sorted({block.drive for plan in plan_list for block in plan.motion.blocks}):
        for axis in np.eye(3):
            for off in (
                {"shift_m": SHARE * PLACE_STD_M * axis},
                {"turn_rad": SHARE * PLACE_STD_RAD * axis},
            ):
                yield Unknown(setting, (Misplaced(drive=drive, **off),), _held_by(drive))


def _held_by(drive: str) -> Callable[[Plan], bool]:
    return lambda plan: any(block.drive == drive for block in plan.motion.blocks)


def seen(track: Track) -> np.ndarray:
    """(F, M, 3) true places at CHECK_TIMES_S."""
    return track.sample(np.repeat(CHECK_TIMES_S[:, None], track.places_m.shape[1], axis=1))
