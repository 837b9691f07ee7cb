"""One motion: where the flat sheet starts, which vertices are held, and the course of each hold."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.concealed.cloth import Cloth

DURATION_S = 4.0
MOVES_AT_S = 0.55
"""Commands rest until then: recordings promise half a second at rest."""

HANGING = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Rest mesh axes (u, v, normal) in a sheet that hangs from row 0: x, -z, y."""


@dataclass(frozen=True)
class Block:
    """The bundle's vertices held by one drive: a rectangle of rows and columns, both ends included."""

    drive: str
    rows: tuple[int, int]
    columns: tuple[int, int]

    def vertices(self, columns: int) -> list[int]:
        """Vertex ids on a mesh with that many columns, row by row."""
        return [
            row * columns + column
            for row in range(self.rows[0], self.rows[1] + 1)
            for column in range(self.columns[0], self.columns[1] + 1)
        ]


Course = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""times (T,) to shift (T, D, 3) in metres and turn (T, D, 3) as a rotation vector, both against the flat sheet's holds."""


@dataclass(frozen=True)
class Motion:
    """A motion in world axes. `flat_rotation` (3, 3) and `flat_origin_m` (3,) place the flat sheet: R (u, v, 0) + origin."""

    name: str
    table: bool
    blocks: tuple[Block, ...]
    flat_rotation: np.ndarray
    flat_origin_m: np.ndarray
    course: Course

    def placed(self, yaw_rad: float, shift_m: np.ndarray) -> "Motion":
        """The same motion turned about the vertical and shifted."""
        turn = Rotation.from_euler("z", yaw_rad).as_matrix()
        course = self.course

        def placed_course(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            shift, rotation = course(times)
            return shift @ turn.T, rotation @ turn.T

        return Motion(
            self.name,
            self.table,
            self.blocks,
            turn @ self.flat_rotation,
            turn @ self.flat_origin_m + shift_m,
            placed_course,
        )


def corners(columns: int, rows: int, deep: int = 2) -> tuple[Block, Block]:
    """Two grippers at the corners of row 0, two columns wide and `deep` rows deep."""
    return (
        Block("left", (0, deep - 1), (0, 1)),
        Block("right", (0, deep - 1), (columns - 2, columns - 1)),
    )


def bar(columns: int, rows: int, deep: int = 2) -> tuple[Block]:
    """A clamp along row 0 that also holds the slope where it is two rows deep."""
    return (Block("bar", (0, deep - 1), (0, columns - 1)),)


def bars(columns: int, rows: int, deep: int = 2) -> tuple[Block, Block]:
    """A clamp along row 0 and one along the last row."""
    return (
        Block("front", (0, deep - 1), (0, columns - 1)),
        Block("back", (rows - deep, rows - 1), (0, columns - 1)),
    )


def hanging_origin(cloth: Cloth, height_m: float = 0.8) -> np.ndarray:
    """Origin of the flat sheet that hangs with row 0 at height_m and its middle at x = 0."""
    return np.array([-cloth.size_u_m / 2, 0.0, height_m])


def course_of(drives: int, parts: Callable[[np.ndarray, np.ndarray, np.ndarray], None]) -> Course:
    """A course from a function that adds to shift and turn (T, D, 3) in place."""

    def course(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        times = np.atleast_1d(np.asarray(times, dtype=float))
        shift, turn = np.zeros((len(times), drives, 3)), np.zeros((len(times), drives, 3))
        parts(times, shift, turn)
        return shift, turn

    return course
