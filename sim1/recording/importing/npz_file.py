"""NumPy archives, for whoever already has arrays: markers, and drives beside them.

Keys: `time_s` (T,), `labels` (M,), `positions` (T, M, 3), optionally `visible` (T, M) and `units`. For each drive NAME, in metres and
with z up: `drive_NAME_time_s` (D,), `drive_NAME_position_m` (D, 3), `drive_NAME_rotation_wxyz` (D, 4), `drive_NAME_open` (D,).
"""

from pathlib import Path

import numpy as np
import pandas as pd

from sim1.array_file import read_arrays
from sim1.recording.importing.paths import MarkerPaths, metres_per_unit, z_up
from sim1.recording.places import own_places
from sim1.recording.streams import DRIVE_COLUMNS, VALUE_COLUMNS, Drives, drives_of
from sim1.stage import BadInput

PARTS = {"time_s": 1, "position_m": 3, "rotation_wxyz": 4, "open": 1}  # of a drive, and numbers a sample


def read_npz(path: Path, units: str | None = None, up: str | None = None) -> MarkerPaths:
    """Read the markers of an archive; NaN or visible=false is a gap. `up` is "z" where not said. Frames count from 0.

    Raises:
        BadInput: not an archive, a key missing or unknown, shapes that do not fit, a frame without a time, a unit that nobody says.
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
    if len(time) == 0:
        raise BadInput(f"{path}: no frame; export the recording")
    if (untimed := ~np.isfinite(time)).any():
        at = int(np.argmax(untimed))
        raise BadInput(f"{path}: frame {at}: time_s is {time[at]}; every frame has its time: export it again")
    visible = arrays.get("visible", np.ones(shape[:2], bool))
    if visible.shape != shape[:2] or visible.dtype != bool:
        raise BadInput(f"{path}: visible is {visible.dtype} {visible.shape}; expected bool {shape[:2]}")
    stated = str(arrays["units"].item()) if "units" in arrays and arrays["units"].size == 1 else None
    factor = metres_per_unit(path, stated, units)
    seen = visible & ~np.isnan(positions).any(-1)
    labels = tuple(str(label) for label in arrays["labels"].ravel())
    return MarkerPaths(
        file=path,
        time_s=time,
        labels=labels,
        positions_m=z_up(np.where(seen[..., None], positions * factor, np.nan), up or "z"),
        rows=np.broadcast_to(np.arange(len(time))[:, None], shape[:2]),
        counted="frame",
    )


def read_npz_drives(path: Path) -> Drives:
    """Read the drives of an archive; none where it has none. Rows of each drive's arrays count from 0.

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
        if count == 0:
            raise BadInput(f"{path}: drive_{name}_time_s is empty; export the drive, or leave its arrays out")
        for part, width in PARTS.items():
            if found[part].shape != (shape := (count, width) if width > 1 else (count,)):
                raise BadInput(f"{path}: drive_{name}_{part} is {found[part].shape}; expected {shape}")
        columns = np.column_stack([found[part] for part in PARTS])
        tables.append(pd.DataFrame(columns, columns=list(VALUE_COLUMNS)).assign(drive=name))
    table = pd.concat(tables) if tables else pd.DataFrame(columns=list(DRIVE_COLUMNS))
    return drives_of(own_places(path), table)


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
