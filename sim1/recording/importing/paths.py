"""What every reader of marker files gives: labelled paths in metres, z up, and how units and axes become so."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.recording.places import Places
from sim1.scan.garment_file import METRES_PER_UNIT
from sim1.stage import BadInput

UNIT_NAMES = {
    "m": "m", "meter": "m", "meters": "m", "metre": "m", "metres": "m",
    "cm": "cm", "centimeters": "cm", "centimetres": "cm",
    "mm": "mm", "millimeters": "mm", "millimetres": "mm",
    "in": "in", "inch": "in", "inches": "in",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class MarkerPaths:
    """Paths of labelled markers on the file's own clock."""

    file: Path
    time_s: np.ndarray  # (T,)
    labels: tuple[str, ...]  # M, as in the file; may repeat where the file's do
    positions_m: np.ndarray  # (T, M, 3) z up, NaN in gaps
    rows: np.ndarray  # (T, M) of the file, as `counted` says; in a gap without a row, the first row of the frame
    counted: str  # "row", or "frame" where a file has no rows

    def place(self, frame: int, column: int = 0) -> str:
        """Where a marker of a frame stands, for messages."""
        return f"{self.file}: {self.counted} {self.rows[frame, column]}"


def marker_places(paths: MarkerPaths) -> Places:
    """Where the rows of the bundle's table stand in the lab's file: a row for each marker and frame."""
    return Places(file=paths.file, row=lambda row: paths.place(*divmod(row, len(paths.labels))))


def metres_per_unit(path: Path, stated: str | None, asked: str | None) -> float:
    """Metres per unit of a file: `stated` by its header, `asked` for by the person; None where not said.

    Raises:
        BadInput: nobody says, they contradict each other, or the unit is unknown.
    """
    known = {name: _unit(path, name) for name in (stated, asked) if name}
    if not known:
        raise BadInput(f"{path}: the file does not say its unit of length; give --units m, cm, mm or in")
    if len(set(known.values())) > 1:
        raise BadInput(
            f"{path}: the file says {stated!r} and --units says {asked!r}; leave --units out, or export again"
        )
    return METRES_PER_UNIT[next(iter(known.values()))]


def _unit(path: Path, name: str) -> str:
    found = UNIT_NAMES.get(name.strip().lower())
    if found is None:
        raise BadInput(f"{path}: unit of length {name!r} is unknown; expected one of {sorted(METRES_PER_UNIT)}")
    return found


def z_up(points: np.ndarray, up: str) -> np.ndarray:
    """Points (..., 3) of a right-handed frame with `up` along "y" or "z", in one with z up; x stays x, y up: -z becomes y."""
    return points if up == "z" else np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def numbers(
    path: Path, cells: Sequence[Sequence[str]], rows: Sequence[int], remedy: str = "leave gaps empty"
) -> np.ndarray:
    """Text cells of n lines as numbers (n, k), empty ones NaN; `rows` are the lines' rows in the file, from 1.

    Raises:
        BadInput: a cell is neither empty nor a finite number.
    """
    values = [[_number(path, word, row, remedy) if word else np.nan for word in line] for line, row in zip(cells, rows)]
    return np.array(values, float).reshape(len(cells), -1)


def _number(path: Path, word: str, row: int, remedy: str) -> float:
    if word.lower() in ("nan", "na", "null"):
        return np.nan
    try:
        value = float(word)
    except ValueError as error:
        raise BadInput(f"{path}: row {row}: {word!r} is not a number; {remedy}") from error
    if not np.isfinite(value):
        raise BadInput(f"{path}: row {row}: {word!r} is not finite; {remedy}")
    return value
