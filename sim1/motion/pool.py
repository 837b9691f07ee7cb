"""The pool of segments: what was cut from which demonstration, and the commands inside it, as two files."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.array_file import Shape, read_numbers
from sim1.motion.poses import ToolPath
from sim1.stage import BadInput

COLUMNS = (
    "segment",  # running number, the key into segments.npz
    "demo",  # name of the demonstration's folder
    "kind",  # interacting or moving
    "order",  # how many segments of this kind come before it in its demonstration
    "start_frame",
    "end_frame",  # excluded
    "grasp_left",  # garment vertex, -1 where the arm grasps nothing
    "grasp_right",
    "success",  # of the demonstration
    "garment",
)
ARRAYS = {"joints_rad": (2, 6), "openness": (2,), "tool_position_m": (2, 3), "tool_rotation": (2, 3, 3)}  # of a frame


@dataclass(frozen=True, kw_only=True)
class Segment:
    """One part of a demonstration."""

    segment: int
    demo: str
    kind: str
    order: int
    start_frame: int
    end_frame: int
    grasp_left: int
    grasp_right: int
    success: bool
    garment: str
    joints_rad: np.ndarray  # (n, 2, 6) commanded
    path: ToolPath  # (n) commanded, world frame

    @property
    def grasps(self) -> list[int]:
        """Grasped garment vertices."""
        return [vertex for vertex in (self.grasp_left, self.grasp_right) if vertex >= 0]


def write_pool(folder: Path, segments: list[Segment]) -> None:
    """Write `segments.parquet` and `segments.npz` into `folder`."""
    rows = [{column: getattr(segment, column) for column in COLUMNS} for segment in segments]
    pd.DataFrame(rows, columns=list(COLUMNS)).to_parquet(folder / "segments.parquet", index=False)
    arrays: dict[str, np.ndarray] = {}
    for segment in segments:
        path = segment.path
        values = (segment.joints_rad, path.openness, path.position_m, path.rotation)
        arrays |= {f"{segment.segment:04d}.{name}": value for name, value in zip(ARRAYS, values, strict=True)}
    np.savez(folder / "segments.npz", **arrays)


def read_pool(folder: Path) -> list[Segment]:
    """Read and check a pool.

    Raises:
        BadInput: a file is missing or damaged, or table and arrays do not fit together.
    """
    remedy = "make segment_pool again"
    try:
        table = pd.read_parquet(folder / "segments.parquet")
    except (OSError, ValueError) as error:
        raise BadInput(f"{folder}/segments.parquet: not a readable segment pool ({error}); {remedy}") from error
    if missing := set(COLUMNS) - set(table.columns):
        raise BadInput(f"{folder}/segments.parquet: columns {sorted(missing)} are missing; {remedy}")
    rows = table[list(COLUMNS)].to_dict("records")
    shapes: dict[str, Shape] = {
        f"{row['segment']:04d}.{name}": (row["end_frame"] - row["start_frame"], *shape)
        for row in rows
        for name, shape in ARRAYS.items()
    }
    arrays = read_numbers(folder / "segments.npz", shapes, "segment pool", remedy)
    segments = []
    for row in rows:
        joints, openness, position, rotation = (arrays[f"{row['segment']:04d}.{name}"] for name in ARRAYS)
        path = ToolPath(position_m=position, rotation=rotation, openness=openness)
        segments.append(Segment(**row, joints_rad=joints, path=path))
    return segments


def by_demo(segments: list[Segment]) -> dict[str, list[Segment]]:
    """Segments of each demonstration, in order of time."""
    result: dict[str, list[Segment]] = {}
    for segment in sorted(segments, key=lambda item: (item.demo, item.start_frame)):
        result.setdefault(segment.demo, []).append(segment)
    return result
