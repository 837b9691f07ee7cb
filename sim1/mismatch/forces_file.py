"""`forces.npz`: the located force at every marker, by recording. `NAME/time_s` (T,) and `NAME/force_n` (T, M, 3), float32."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim1.array_file import Shape, numbers_of, read_arrays
from sim1.stage import BadInput

if TYPE_CHECKING:
    from sim1.mismatch.missing_force import Forces  # reading the file needs no simulator

WHAT, REMEDY = "file of forces", "diagnose the bundle again"

type ForceCourses = dict[str, tuple[np.ndarray, np.ndarray]]
"""Recording -> time_s (T,) and force_n (T, M, 3), markers by rising number."""


def write_forces(path: Path, forces: "tuple[Forces, ...]") -> None:
    """Write the forces of all recordings."""
    arrays = {}
    for one in forces:
        arrays[f"{one.name}/time_s"] = one.time_s.astype(np.float32)
        arrays[f"{one.name}/force_n"] = one.force_n.astype(np.float32)
    with path.open("wb") as file:
        np.savez_compressed(file, **arrays)


def read_forces(path: Path) -> ForceCourses:
    """Read what `write_forces` wrote.

    Raises:
        BadInput: missing or damaged, or an array is missing, of another shape, of no instant or not finite.
    """
    arrays = read_arrays(path, (), WHAT, REMEDY)
    names = [key.removesuffix("/time_s") for key in arrays if key.endswith("/time_s")]
    shapes: dict[str, Shape] = {}
    for name in names:
        shapes |= {f"{name}/time_s": (f"T of {name}",), f"{name}/force_n": (f"T of {name}", "M", 3)}
    checked = numbers_of(arrays, path, shapes, WHAT, REMEDY)
    for name in names:
        if not len(checked[f"{name}/time_s"]):
            raise BadInput(f"{path}: array '{name}/time_s' is of no instant; {REMEDY}")
    return {name: (checked[f"{name}/time_s"], checked[f"{name}/force_n"]) for name in names}
