"""C3D files, the exchange format of motion-capture labs, through ezc3d."""

from pathlib import Path

import numpy as np

from sim1.recording.importing.paths import MarkerPaths, metres_per_unit, z_up
from sim1.stage import BadInput

LAST_WORD = 65535  # a longer file writes this as its last frame


def read_c3d(path: Path, units: str | None = None, up: str | None = None) -> MarkerPaths:
    """Read the points of a C3D file; a negative residual is a gap. `up` is "z" where not said. The file's frame 1 is at 0 s.

    Raises:
        BadInput: not a C3D file, cut short, no points, no rate, a unit that nobody says.
    """
    import ezc3d

    if not path.is_file():
        raise BadInput(f"{path}: no such file; name the C3D file")
    try:
        content = ezc3d.c3d(str(path))
    except Exception as error:  # damaged files raise many kinds
        raise BadInput(
            f"{path}: not a readable C3D file ({' '.join(str(error).split())[:120]}); export it again"
        ) from error
    group, data = content["parameters"]["POINT"], content["data"]
    points = np.asarray(data["points"], float)[:3].transpose(2, 1, 0)
    header = content["header"]["points"]
    if points.size == 0:
        raise BadInput(f"{path}: no points in any frame; export the trajectories")
    if len(points) < (promised := _promised_frames(path)):
        raise BadInput(
            f"{path}: the header promises {promised} frames, the file holds {len(points)}; it was cut short: copy it again"
        )
    names = [group[key]["value"] for key in sorted(group, key=lambda key: (len(key), key)) if key.startswith("LABELS")]
    labels = tuple(str(label).strip() for some in names for label in some)
    if len(labels) < points.shape[1]:
        raise BadInput(f"{path}: {points.shape[1]} points and {len(labels)} labels; label the points and export again")
    hertz = float(np.ravel(group["RATE"]["value"])[0]) if np.size(group.get("RATE", {}).get("value", [])) else 0.0
    if not hertz > 0:
        raise BadInput(f"{path}: POINT:RATE is {hertz}; expected the frame rate in Hz")
    stated = [str(unit).strip() for unit in group.get("UNITS", {}).get("value", []) if str(unit).strip()]
    factor = metres_per_unit(path, stated[0] if stated else None, units)
    lost = (
        (np.asarray(data["meta_points"]["residuals"])[0].T < 0) | (points == 0).all(-1) | ~np.isfinite(points).all(-1)
    )
    positions = np.where(lost[..., None], np.nan, points)
    time = (header["first_frame"] + np.arange(len(points))) / hertz
    return MarkerPaths(time_s=time, labels=labels[: points.shape[1]], positions_m=z_up(positions * factor, up or "z"))


def _promised_frames(path: Path) -> int:
    """Frames by the file's header (the library counts what is there); 0 where it does not say."""
    start = path.read_bytes()
    parameters = (start[0] - 1) * 512
    order = ">u2" if start[parameters + 3 : parameters + 4] == b"\x56" else "<u2"  # 86: a MIPS machine wrote it
    first, last = (int(word) for word in np.frombuffer(start[6:10], order))
    return 0 if last == LAST_WORD else last - first + 1
