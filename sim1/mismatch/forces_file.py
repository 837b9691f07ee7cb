"""`forces.npz`: the located force at every marker, by recording. `NAME/time_s` (T,) and `NAME/force_n` (T, M, 3), float32."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim1.array_file import read_arrays
from sim1.stage import BadInput

if TYPE_CHECKING:
    from sim1.mismatch.assimilate import Forces  # reading the file needs no simulator

REMEDY = "diagnose the bundle again"

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
        BadInput: missing or damaged.
    """
    arrays = read_arrays(path, (), "file of forces", REMEDY)
    names = [key.removesuffix("/time_s") for key in arrays if key.endswith("/time_s")]
    if lost := [name for name in names if f"{name}/force_n" not in arrays]:
        raise BadInput(f"{path}: no array {lost[0] + '/force_n'!r} beside its times; {REMEDY}")
    return {name: (arrays[f"{name}/time_s"], arrays[f"{name}/force_n"]) for name in names}
