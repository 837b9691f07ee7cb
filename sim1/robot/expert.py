"""The scripted expert: plans how both arms do one step of a task on the garment as it lies.

It stands in for a person who teleoperates the robot. It knows where the garment's vertices are, and acts on the garment
through the fingers alone: press them down open, close them so that friction gathers a ridge of cloth between the pads, lift.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

import numpy as np

from sim1.episode import ARMS
from sim1.robot.expert_path import FRAME_S, Path3, min_jerk
from sim1.robot.expert_task import ArmMove, Step, Task, find_keypoints, ideal_fold, mirror
from sim1.robot.expert_variation import Variation
from sim1.robot.gripper import below_m
from sim1.robot.kinematics import Arm, Unreachable
from sim1.scene.description import Scene

ABOVE_M = 0.09  # height over the table from which a grasp is approached
RETREAT_M = 0.15  # height to which opened fingers rise before the arms turn away: over the pile of a folded shirt
PRESS_M = 0.0005  # lowest edge of the fingers at a grasp: inside the cloth's contact layer, so that they press on it
LAY_M = 0.012  # this much higher when letting go
RELEASE_OPENNESS = 0.40  # 35 mm
SLACK_M = 0.005  # each hand moves this far towards the other: closing fingers have drawn the cloth between them taut
SPEED_SHARE = 0.9  # of the joints' speed limits that a plan may use
PACES = 4  # a plan that asks for more is slowed down, until it was tried so often
TILTS_RAD = np.arange(0.0, 1.01, 0.1)  # of the fingers from straight down to forward; the first that reaches is taken


class TooFast(RuntimeError):
    """A joint would move faster than a plan may, however much the plan was slowed down."""

    def __init__(self, ratio: float) -> None:
        super().__init__(
            f"slowed down {PACES - 1} times, a joint would still move at {100 * ratio:.0f} % of its speed limit, "
            f"a plan may use {100 * SPEED_SHARE:.0f} %"
        )


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Commands of one step at 30 Hz."""

    joints_rad: np.ndarray  # (n, 2, 6)
    openness: np.ndarray  # (n, 2)


@dataclass(frozen=True, kw_only=True)
class Workspace:
    """Both arms and where they stand."""

    arms: tuple[Arm, Arm]
    bases: np.ndarray  # (2, 4, 4) base to world
    home_rad: np.ndarray  # (2, 6) drawn back from the garment

    @classmethod
    def of(cls, arms: tuple[Arm, Arm], scene: Scene) -> "Workspace":
        """The arms where the scene has them."""
        bases, homes = scene.base_to_world, scene.home_rad
        return cls(arms=arms, bases=np.stack([bases[a] for a in ARMS]), home_rad=np.stack([homes[a] for a in ARMS]))

    def inverse(self, side: int, tool: np.ndarray, start: np.ndarray, *, restarts: int = 0) -> np.ndarray:
        """Joints (6,) that put the tool of an arm at `tool` (4, 4), world frame; raises Unreachable."""
        return self.arms[side].inverse(np.linalg.inv(self.bases[side]) @ tool, start, restart_count=restarts)


def tool_pose(position: np.ndarray, tilt_rad: float, yaw_rad: float) -> np.ndarray:
    """Tool frame (4, 4) with fingers down, tilted forward, their opening turned by yaw about them from +y."""
    along = np.array([np.sin(tilt_rad), 0.0, -np.cos(tilt_rad)])
    side, across = np.array([0.0, 1.0, 0.0]), np.array([np.cos(tilt_rad), 0.0, np.sin(tilt_rad)])
    opening = np.cos(yaw_rad) * side + np.sin(yaw_rad) * across
    pose = np.eye(4)
    pose[:3, :3] = np.stack([along, opening, np.cross(along, opening)], axis=1)
    pose[:3, 3] = position
    return pose


def plan_step(
    workspace: Workspace,
    task: Task,
    index: int,
    start_m: np.ndarray,
    garment_m: np.ndarray,
    joints_rad: np.ndarray,
    variation: Variation,
) -> Plan:
    """Plan step `index` from the present garment and joints.

    Args:
        workspace: the arms.
        task: the whole task.
        index: of the step.
        start_m: (v, 3) garment before anything moved; keypoints are defined on it.
        garment_m: (v, 3) garment now.
        joints_rad: (2, 6) now.
        variation: of this demonstration.

    Raises:
        Unreachable: a point of the way is out of an arm's reach, whatever the tilt of its fingers.
        TooFast: it asks too much of a joint.
    """
    step = task.steps[index]
    grasp, place = _points(task, index, start_m, garment_m, variation)
    lift = max(step.lift_m + variation.lift_shift_m, 0.03)
    others = [_tilts(workspace, side, step, grasp, place, lift) for side in range(2)]
    tilt = [next(some) for some in others]
    apart = grasp[1] - grasp[0]
    slack = SLACK_M * np.stack([apart, -apart]) / max(float(np.linalg.norm(apart)), 1e-9)
    pace, pauses = variation.pace, variation.pauses_s
    for _ in range(PACES):
        path = Path3(_at(grasp, ABOVE_M + PRESS_M), step.opening)
        path.move(_at(grasp, PRESS_M), 0.6 * pace)
        path.hold(0.1 + pauses[0])
        path.grip(0.0, 0.45 * pace)
        path.hold(0.1)
        path.arc(_at(place + slack, LAY_M + PRESS_M), lift, step.carry_s * pace, variation)
        path.hold(0.1 + pauses[1])
        path.grip(RELEASE_OPENNESS, 0.6 * pace)
        path.move(_at(place + slack, RETREAT_M + PRESS_M), 1.2 * pace)
        joints = np.empty((len(path.openness()), 2, 6))
        for side in range(2):
            untried = chain([tilt[side]], others[side])
            joints[:, side], tilt[side] = _followed(workspace, side, path, untried, step, joints_rad[side])
        ratio = _speed_ratio(workspace, joints)
        if ratio <= SPEED_SHARE:
            break
        pace *= 1.05 * ratio / SPEED_SHARE
    else:
        raise TooFast(ratio)
    openness = path.openness()
    there, back = (
        _joint_move(workspace, joints_rad, joints[0], pace),
        _joint_move(workspace, joints[-1], workspace.home_rad, pace),
    )
    return Plan(
        joints_rad=np.concatenate([there, joints, back]),
        openness=np.concatenate(
            [
                np.repeat(openness[:1], len(there), axis=0),
                openness,
                openness[-1] + min_jerk(np.linspace(0, 1, len(back)))[:, None] * (1.0 - openness[-1]),
            ]
        ),
    )


def _points(
    task: Task, index: int, start_m: np.ndarray, garment_m: np.ndarray, variation: Variation
) -> tuple[np.ndarray, np.ndarray]:
    """Grasp and placing points on the table, (2, 2) each."""
    step = task.steps[index]
    marks = find_keypoints(start_m, task)
    ideal = ideal_fold(start_m, task, index)
    low, high = ideal.min(axis=0), ideal.max(axis=0)
    now = garment_m[:, :2]
    middle = 0.5 * (now.min(axis=0) + now.max(axis=0))
    grasp, place = np.empty((2, 2)), np.empty((2, 2))
    for side, move in enumerate((step.left, step.right)):
        grasp[side] = _grasp(now[marks[move.grasp]], middle, move) + variation.grasp_shift_m[side]
        place[side] = mirror(grasp[side], move.fold, low, high)
        axis = "xy".index(move.fold.axis)
        place[side, axis] -= step.short_m * np.sign(place[side, axis] - grasp[side, axis])
    return grasp, place


def _grasp(keypoint: np.ndarray, middle: np.ndarray, move: ArmMove) -> np.ndarray:
    return keypoint + np.sign(middle - keypoint) * np.array(move.inset_m)


def _at(points: np.ndarray, height: float | np.ndarray) -> np.ndarray:
    return np.concatenate([points, np.broadcast_to(height, (2,))[:, None]], axis=1)


def _tilts(
    workspace: Workspace, side: int, step: Step, grasp: np.ndarray, place: np.ndarray, lift: float
) -> Iterator[float]:
    """Tilts with which eight points about the way are in reach, smallest first; `_followed` sees whether all of it is.

    Raises:
        Unreachable: there is none.
    """
    found = False
    problem: Unreachable | None = None
    yaw = np.radians(step.yaw_deg) * (1.0, -1.0)[side]
    for tilt in TILTS_RAD:
        joints = workspace.home_rad[side]
        try:
            for share in np.linspace(0.0, 1.0, 6):
                point = np.append(grasp[side] + share * (place[side] - grasp[side]), 0.0)
                heights = {0.0: (ABOVE_M, 0.0), 1.0: (0.0, RETREAT_M)}.get(
                    share, (lift * np.sin(np.pi * share) + 0.02,)
                )
                for height in heights:
                    point[2] = height
                    restarts = 6 if share == 0.0 and height == ABOVE_M else 1
                    joints = workspace.inverse(side, tool_pose(point, tilt, yaw), joints, restarts=restarts)
        except Unreachable as error:
            if problem is None or error.position_error_m < problem.position_error_m:
                problem = error
            continue
        found = True
        yield float(tilt)
    if not found:
        assert problem is not None
        raise problem


def _followed(
    workspace: Workspace, side: int, path: Path3, tilts: Iterator[float], step: Step, start: np.ndarray
) -> tuple[np.ndarray, float]:
    """Joints (n, 6) of an arm along all of `path` with the first tilt that allows it, and that tilt.

    Raises:
        Unreachable: with every tilt; of the first one.
    """
    problem: Unreachable | None = None
    for tilt in tilts:
        try:
            return _solve(workspace, side, path, tilt, step, start), tilt
        except Unreachable as error:
            problem = problem or error
    assert problem is not None
    raise problem


def _solve(workspace: Workspace, side: int, path: Path3, tilt: float, step: Step, start: np.ndarray) -> np.ndarray:
    """Joints (n, 6), each frame from the one before, with the lowest edge of the fingers where `path` has the tool."""
    yaw = np.radians(step.yaw_deg) * (1.0, -1.0)[side]
    positions, openness = path.positions()[:, side], path.openness()[:, side]
    positions[:, 2] += below_m(tool_pose(np.zeros(3), tilt, yaw)[:3, :3], openness)
    joints, now = np.empty((len(positions), 6)), np.array(start)
    for frame, point in enumerate(positions):
        now = workspace.inverse(side, tool_pose(point, tilt, yaw), now, restarts=6 if frame == 0 else 0)
        joints[frame] = now
    return joints


def _speed_ratio(workspace: Workspace, joints: np.ndarray) -> float:
    """Largest joint speed over its limit."""
    limits = np.stack([arm.velocity_limit_rad_s for arm in workspace.arms])
    return float((np.abs(np.diff(joints, axis=0)) / (limits * FRAME_S)).max())


def _joint_move(workspace: Workspace, start: np.ndarray, end: np.ndarray, pace: float) -> np.ndarray:
    """Minimum-jerk way (n, 2, 6) in joint space, within the speed limits; a minimum jerk peaks at 1.875 times its mean."""
    limits = np.stack([arm.velocity_limit_rad_s for arm in workspace.arms])
    seconds = max(0.6 * pace, float((1.875 * np.abs(end - start) / (0.6 * limits)).max()))
    share = min_jerk(np.linspace(0.0, 1.0, max(2, round(seconds / FRAME_S))))
    return start + share[:, None, None] * (end - start)
