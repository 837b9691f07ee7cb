"""`forces.npz`: the located force at every marker, by recording. `NAME/time_s` (T,) and `NAME/force_n` (T, M, 3), float32."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sim1.stage import BadInput

if TYPE_CHECKING:
    from sim1.mismatch.assimilate import Forces  # reading the file needs no simulator

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
    try:
        with np.load(path) as file:
            names = [key.removesuffix("/time_s") for key in file.files if key.endswith("/time_s")]
            return {name: (file[f"{name}/time_s"], file[f"{name}/force_n"]) for name in names}
    except Exception as error:  # zipfile, zlib and numpy each have errors of their own for a damaged file
        raise BadInput(f"{path}: not readable ({error}); diagnose the bundle again") from error
