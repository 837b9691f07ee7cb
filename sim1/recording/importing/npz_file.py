"""NumPy archives, for whoever already has arrays: markers, and drives beside them.

Keys: `time_s` (T,), `labels` (M,), `positions` (T, M, 3), optionally `visible` (T, M) and `units`. For each drive NAME, in metres and
with z up: `drive_NAME_time_s` (D,), `drive_NAME_position_m` (D, 3), `drive_NAME_rotation_wxyz` (D, 4), `drive_NAME_open` (D,).
"""

from pathlib import Path

import numpy as np
import pandas as pd

from sim1.array_file import read_arrays
from sim1.recording.importing.paths import MarkerPaths, metres_per_unit, z_up
from sim1.recording.streams import DRIVE_COLUMNS, Track, drives_of
from sim1.stage import BadInput

PARTS = {"time_s": 1, "position_m": 3, "rotation_wxyz": 4, "open": 1}  # of a drive, and numbers a sample


def read_npz(path: Path, units: str | None = None, up: str | None = None) -> MarkerPaths:
    """Read the markers of an archive; NaN or visible=false is a gap. `up` is "z" where not said.

    Raises:
        BadInput: not an archive, a key missing or unknown, shapes that do not fit, a unit that nobody says.
    """
    arrays = _arrays(path)
    for key in ("time_s", "labels", "positions"):
        if key not in arrays:
            raise BadInput(f"{path}: no key {key!r}; there are {sorted(arrays)}")
    time, positions = _floats(path, arrays, "time_s"), _floats(path, arrays, "positions")
    shape = (len(time), arrays["labels"].size, 3) if time.ndim == 1 else ()
    if positions.shape != shape:
        raise BadInput(
            f"{path}: positions are {positions.shape}, time_s {time.shape} and labels {arrays['labels'].shape}; "
            "expected (T, M, 3), (T,) and (M,)"
        )
    visible = arrays.get("visible", np.ones(shape[:2], bool))
    if visible.shape != shape[:2] or visible.dtype != bool:
        raise BadInput(f"{path}: visible is {visible.dtype} {visible.shape}; expected bool {shape[:2]}")
    stated = str(arrays["units"].item()) if "units" in arrays and arrays["units"].size == 1 else None
    factor = metres_per_unit(path, stated, units)
    seen = visible & np.isfinite(positions).all(-1)
    labels = tuple(str(label) for label in arrays["labels"].ravel())
    return MarkerPaths(
        time_s=time, labels=labels, positions_m=z_up(np.where(seen[..., None], positions * factor, np.nan), up or "z")
    )


def read_npz_drives(path: Path) -> dict[str, Track]:
    """Read the drives of an archive; none where it has none.

    Raises:
        BadInput: not an archive, a part of a drive missing, shapes that do not fit, a damaged path.
    """
    arrays = _arrays(path)
    names = sorted(
        {key.removeprefix("drive_").removesuffix(f"_{part}") for key in arrays for part in PARTS if _is(key, part)}
    )
    tables = []
    for name in names:
        found = {part: _floats(path, arrays, f"drive_{name}_{part}") for part in PARTS}
        count = found["time_s"].size
        if wrong := [part for part, width in PARTS.items() if found[part].size != count * width]:
            raise BadInput(f"{path}: drive_{name}_{wrong[0]} is {found[wrong[0]].shape} for {count} time stamps")
        columns = np.column_stack([found[part].reshape(count, -1) for part in PARTS])
        table = pd.DataFrame(columns, columns=[column for column in DRIVE_COLUMNS if column != "drive"])
        tables.append(table.assign(drive=name))
    return drives_of(path, pd.concat(tables, ignore_index=True)) if tables else {}


def _is(key: str, part: str) -> bool:
    return key.startswith("drive_") and key.endswith(f"_{part}")


def _floats(path: Path, arrays: dict[str, np.ndarray], key: str) -> np.ndarray:
    if key not in arrays:
        raise BadInput(f"{path}: no key {key!r}; there are {sorted(arrays)}")
    if arrays[key].dtype.kind not in "iuf":
        raise BadInput(f"{path}: {key} holds {arrays[key].dtype}; expected numbers")
    return arrays[key].astype(float)


def _arrays(path: Path) -> dict[str, np.ndarray]:
    arrays = read_arrays(path, (), ".npz without pickles", "export it again")
    known = {"time_s", "labels", "positions", "visible", "units"}
    if unknown := sorted(key for key in arrays if key not in known and not any(_is(key, part) for part in PARTS)):
        raise BadInput(
            f"{path}: key {unknown[0]!r} is unknown; expected {sorted(known)} and drive_NAME_{{{', '.join(PARTS)}}}"
        )
    return arrays
