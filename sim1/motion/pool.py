"""The pool of segments: what was cut from which demonstration, and the commands inside it, as two files."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

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
ARRAYS = ("joints_rad", "openness", "tool_position_m", "tool_rotation")


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
    try:
        table = pd.read_parquet(folder / "segments.parquet")
        with np.load(folder / "segments.npz", allow_pickle=False) as data:
            arrays = dict(data)
    except (OSError, ValueError) as error:
        raise BadInput(f"{folder}: not a readable segment pool ({error}); make segment_pool again") from error
    if missing := set(COLUMNS) - set(table.columns):
        raise BadInput(f"{folder}/segments.parquet: columns {sorted(missing)} are missing; make segment_pool again")
    segments = []
    for row in table[list(COLUMNS)].to_dict("records"):
        values = [arrays.get(f"{row['segment']:04d}.{name}") for name in ARRAYS]
        length = row["end_frame"] - row["start_frame"]
        if any(value is None or len(value) != length for value in values):
            raise BadInput(
                f"{folder}/segments.npz: segment {row['segment']} has not its {length} frames; make it again"
            )
        joints, openness, position, rotation = values
        path = ToolPath(position_m=position, rotation=rotation, openness=openness)
        segments.append(Segment(**row, joints_rad=joints, path=path))
    return segments


def by_demo(segments: list[Segment]) -> dict[str, list[Segment]]:
    """Segments of each demonstration, in order of time."""
    result: dict[str, list[Segment]] = {}
    for segment in sorted(segments, key=lambda item: (item.demo, item.start_frame)):
        result.setdefault(segment.demo, []).append(segment)
    return result
