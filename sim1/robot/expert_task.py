"""What the robot is to do to a garment, as data (`data/tasks/G.yaml`, `sim1.task/1`)."""

from pathlib import Path
from typing import Literal

import numpy as np
import pydantic

from sim1.data_file import read_data_file
from sim1.stage import stage_config

SCHEMA = "sim1.task/1"


@stage_config
class FoldLine:
    """A line across the garment's bounding box on the table; what lies on the grasp's side of it is turned over."""

    axis: Literal["x", "y"]  # world axis across the line: x is forward
    at: float = pydantic.Field(ge=0.0, le=1.0)  # share of the bounding box along that axis


@stage_config
class ArmMove:
    """What one arm does in a step."""

    grasp: str  # name of a keypoint
    fold: FoldLine
    inset_m: tuple[float, float] = (0.02, 0.02)  # grasp: this far inwards from the keypoint, along x and y


@stage_config
class Step:
    """One fold with both arms: grasp, lift, carry over, lay down, let go, draw back."""

    name: str
    left: ArmMove
    right: ArmMove
    opening: float = pydantic.Field(0.40, gt=0.0, le=1.0)  # openness when pressed down: 35 mm between the pads at 0.4
    lift_m: float = 0.12  # height of the arc above the table half-way
    carry_s: float = 2.0
    short_m: float = 0.0  # lay down this far short of the mirror image (the cloth runs ahead when let go)
    yaw_deg: float = (
        90.0  # of the fingers' opening from +y, left arm, mirrored for the right: 90 opens along x, across the fold
    )


@stage_config
class Limits:
    """When the garment counts as folded."""

    iou: float = 0.75  # of the silhouette with that of the ideal fold
    keypoint_error_m: float = 0.06  # worst grasped point from its ideal place, on the table
    area_excess: float = 0.12  # silhouette area above the ideal one, share of the area at the start
    height_m: float = 0.08  # of the highest vertex at the end
    speed_m_s: float = 0.05  # at the end, 99th percentile over vertices
    stretch: float = 1.35  # longest ratio of edge length to rest length, 99th percentile over edges
    face_down_share: float = 0.0  # of the fabric's area: at least so much lies turned over at the end
    lifted_m: float = 0.03  # a grasp that never lifted its point this high missed


@stage_config
class Task:
    """Keypoints by direction, the folds in order, and the limits of success."""

    title: str
    text: str | None = pydantic.Field(None, pattern=r"^\S.*\S$")  # what a policy is told, one line; see `instruction`
    keypoints: dict[str, tuple[float, float]]  # extreme point of the settled silhouette in this direction (x, y)
    steps: tuple[Step, ...] = pydantic.Field(min_length=1)
    success: Limits = Limits()

    @pydantic.model_validator(mode="after")
    def _known_keypoints(self) -> "Task":
        for step in self.steps:
            for move in (step.left, step.right):
                if move.grasp not in self.keypoints:
                    raise ValueError(
                        f"step {step.name!r} grasps {move.grasp!r}, keypoints are {sorted(self.keypoints)}"
                    )
        if any(np.hypot(*direction) == 0.0 for direction in self.keypoints.values()):
            raise ValueError("a keypoint's direction has no length")
        return self

    def instruction(self, garment: str) -> str:
        """The task in words, as a policy that reads language is given it."""
        return self.text or f"fold the {garment}"


def read_task(path: Path) -> Task:
    """Read a task file (or `task.json` of an artifact, which is YAML too).

    Raises:
        BadInput: not readable, unknown key, wrong value.
    """
    return read_data_file(path, Task, SCHEMA)


def find_keypoints(garment_m: np.ndarray, task: Task) -> dict[str, int]:
    """Vertex of each keypoint: the extreme one of (v, 3) in its direction on the table."""
    return {
        name: int(np.argmax(garment_m[:, :2] @ (np.array(way) / np.hypot(*way))))
        for name, way in task.keypoints.items()
    }


def mirror(points: np.ndarray, fold: FoldLine, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Points (..., 2) reflected over the line across the bounding box `low` (2,) to `high` (2,)."""
    axis = "xy".index(fold.axis)
    turned = np.array(points, float)
    turned[..., axis] = 2.0 * (low[axis] + fold.at * (high[axis] - low[axis])) - turned[..., axis]
    return turned


def ideal_fold(garment_m: np.ndarray, task: Task, step_count: int | None = None) -> np.ndarray:
    """Where the vertices lie on the table, (v, 2), after perfect folds of the garment (v, 3) that lies flat."""
    flat = np.array(garment_m[:, :2], float)
    marks = find_keypoints(garment_m, task)
    for step in task.steps[:step_count]:
        before, low, high = flat.copy(), flat.min(axis=0), flat.max(axis=0)
        for move in (step.left, step.right):
            axis = "xy".index(move.fold.axis)
            line = low[axis] + move.fold.at * (high[axis] - low[axis])
            side = np.sign(before[marks[move.grasp], axis] - line)
            beyond = (before[:, axis] - line) * side > 0.0
            flat[beyond] = mirror(before[beyond], move.fold, low, high)
    return flat
