"""C3D files, the exchange format of motion-capture labs, through ezc3d."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from sim1.recording.importing.paths import MarkerPaths, metres_per_unit, z_up
from sim1.stage import BadInput

LAST_WORD = 65535  # a longer file writes this as its last frame
LONGEST_S = 600  # that reading may take


def read_c3d(path: Path, units: str | None = None, up: str | None = None) -> MarkerPaths:
    """Read the points of a C3D file; a negative residual or a NaN is a gap. `up` is "z" where not said. The file's frame 1 is at 0 s.

    Raises:
        BadInput: not a C3D file, cut short, no points, no rate, a unit that nobody says.
    """
    if not path.is_file():
        raise BadInput(f"{path}: no such file; name the C3D file")
    arrays = _arrays(path)
    points, lost, labels = arrays["points"], arrays["lost"], tuple(str(label) for label in arrays["labels"])
    if points.size == 0:
        raise BadInput(f"{path}: no points in any frame; export the trajectories")
    if len(points) < (promised := _promised_frames(path)):
        raise BadInput(
            f"{path}: the header promises {promised} frames, the file holds {len(points)}; it was cut short: copy it again"
        )
    if lost.shape != points.shape[:2] or len(labels) < points.shape[1]:
        raise BadInput(
            f"{path}: {points.shape[1]} points, {len(labels)} labels, residuals {lost.shape}; label the points and export again"
        )
    hertz = float(arrays["rate"][0]) if len(arrays["rate"]) else 0.0
    if not 0 < hertz < np.inf:
        raise BadInput(f"{path}: POINT:RATE is {hertz}; expected the frame rate in Hz")
    stated = next((str(unit) for unit in arrays["units"] if unit), None)
    positions = np.where(lost[..., None], np.nan, points) * metres_per_unit(path, stated, units)
    frame = int(arrays["first_frame"]) + np.arange(len(points))  # from 0, where the file counts from 1
    return MarkerPaths(
        file=path,
        time_s=frame / hertz,
        labels=labels[: points.shape[1]],
        positions_m=z_up(positions, up or "z"),
        rows=np.broadcast_to(frame[:, None] + 1, lost.shape),
        counted="frame",
    )


def _arrays(path: Path) -> dict[str, np.ndarray]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "points.npz"
        words = [sys.executable, "-m", "sim1.recording.importing.c3d_worker", str(path.resolve()), str(out)]
        try:
            done = subprocess.run(words, capture_output=True, text=True, timeout=LONGEST_S, check=False)
        except subprocess.TimeoutExpired as error:
            raise BadInput(f"{path}: reading took more than {LONGEST_S} s; export it again") from error
        if done.returncode or not out.is_file():
            said = done.stderr.strip().splitlines()
            raise BadInput(
                f"{path}: not a readable C3D file ({said[-1][:160] if said else 'damaged inside'}); export it again"
            )
        with np.load(out, allow_pickle=False) as archive:
            return {key: archive[key] for key in archive.files}


def _promised_frames(path: Path) -> int:
    """Frames by the file's header (the library counts what is there); 0 where it does not say."""
    with path.open("rb") as stream:
        start = stream.read(512 * 256)
    parameters = (start[0] - 1) * 512
    order = ">u2" if start[parameters + 3 : parameters + 4] == b"\x56" else "<u2"  # 86: a MIPS machine wrote it
    first, last = (int(word) for word in np.frombuffer(start[6:10], order))
    return 0 if last == LAST_WORD else last - first + 1
