"""Recording bundles, format `sim1.recordings/1`: what a lab hands over, read strictly and written back.

SI units, right-handed frame, z up. A bundle that reads without an error is consistent: every index, clock and unit was checked.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim1.recording.document import SCHEMA, Document, Environment, HoldPart, Priors, read_document, write_document
from sim1.recording.mesh import RestMesh, read_mesh, write_mesh
from sim1.recording.streams import (
    Anchors,
    Track,
    read_anchors,
    read_drives,
    read_markers,
    write_anchors,
    write_drives,
    write_markers,
)
from sim1.stage import BadInput

CLOCK_SLACK_S = 0.1  # a hold may be stamped by a rounded time


@dataclass(frozen=True, kw_only=True)
class Hold:
    """Mesh vertices that move rigidly with a drive for a while."""

    drive: str
    vertices: np.ndarray  # (h,)
    from_s: float
    to_s: float
    places_m: np.ndarray | None  # (h, 3) in the drive's frame; None: not measured


@dataclass(frozen=True, kw_only=True)
class Recording:
    """One motion: T frames of M markers, and what the drives were told."""

    name: str
    starts: str  # "rest" or "moving"
    holds: tuple[Hold, ...]
    time_s: np.ndarray  # (T,) clock of the markers
    markers_m: np.ndarray  # (T, M, 3), NaN where a marker was not seen
    drives: dict[str, Track]

    @property
    def seen(self) -> np.ndarray:
        """Whether each marker was seen, (T, M)."""
        return np.isfinite(self.markers_m).all(-1)


@dataclass(frozen=True, kw_only=True)
class Bundle:
    """One garment and its recorded motions."""

    mesh: RestMesh
    prior: Priors
    environment: Environment
    noise_std_m: float | None  # of the markers, per coordinate; None: not known
    anchors: Anchors
    recordings: tuple[Recording, ...]


def read_bundle(folder: Path) -> Bundle:
    """Read and check a bundle.

    Raises:
        BadInput: anything missing, damaged or inconsistent; names the file, the row, the value and the remedy.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder}: not a folder; expected a recording bundle with bundle.yaml, schema {SCHEMA}")
    document = read_document(folder / "bundle.yaml")
    mesh = read_mesh(folder / document.garment.mesh)
    anchors = read_anchors(folder / "anchors.parquet", len(mesh.faces))
    recordings = []
    for part in document.recordings:
        place = folder / "recordings" / part.name
        time_s, markers_m = read_markers(place / "markers.parquet", anchors.marker)
        drives = read_drives(place / "drives.parquet")
        _check_holds(folder / "bundle.yaml", part.name, part.holds, drives, len(mesh.vertices_m))
        _check_scale(place, mesh, markers_m, time_s, drives, bool(part.holds))
        holds = tuple(
            Hold(
                drive=hold.drive,
                vertices=np.array(hold.vertices),
                from_s=hold.from_s,
                to_s=hold.to_s,
                places_m=None if hold.places_m is None else np.array(hold.places_m, dtype=float),
            )
            for hold in part.holds
        )
        recordings.append(
            Recording(
                name=part.name, starts=part.starts, holds=holds, time_s=time_s, markers_m=markers_m, drives=drives
            )
        )
    return Bundle(
        mesh=mesh,
        prior=document.garment.prior,
        environment=document.environment,
        noise_std_m=document.markers.noise_std_m,
        anchors=anchors,
        recordings=tuple(recordings),
    )


def _check_holds(path: Path, name: str, holds: list[HoldPart], drives: dict[str, Track], vertex_count: int) -> None:
    for hold in holds:
        place = f"{path}: recording {name}: hold of drive {hold.drive!r}"
        if hold.drive not in drives:
            raise BadInput(f"{place}: drives.parquet has {sorted(drives)}; name one of them")
        if max(hold.vertices) >= vertex_count:
            raise BadInput(
                f"{place}: vertex {max(hold.vertices)} is unknown; the mesh has {vertex_count}, counted from 0"
            )
        first, last = drives[hold.drive].time_s[[0, -1]]
        if hold.from_s < first - CLOCK_SLACK_S or hold.to_s > last + CLOCK_SLACK_S:
            raise BadInput(
                f"{place}: {hold.from_s} to {hold.to_s} s lies outside the recording ({first:.3f} to {last:.3f} s of the drive)"
            )


def _check_scale(
    folder: Path, mesh: RestMesh, markers_m: np.ndarray, time_s: np.ndarray, drives: dict[str, Track], held: bool
) -> None:
    size = float(np.linalg.norm(np.ptp(mesh.vertices_m, axis=0)))
    spread = np.array(
        [
            np.linalg.norm(np.ptp(frame[np.isfinite(frame[:, 0])], axis=0)) if np.isfinite(frame[:, 0]).any() else 0.0
            for frame in markers_m
        ]
    )
    if spread.max() > 1.5 * size + 0.05:
        frame = int(spread.argmax())
        raise BadInput(
            f"{folder / 'markers.parquet'}: at {time_s[frame]} s the markers span {spread.max():.3g} m on a cloth of {size:.3g} m; "
            "are they in millimetres, or is a marker mislabelled?"
        )
    first = min(track.time_s[0] for track in drives.values())
    last = max(track.time_s[-1] for track in drives.values())
    if time_s[0] > last or time_s[-1] < first:
        raise BadInput(
            f"{folder / 'markers.parquet'}: markers run from {time_s[0]:.3f} to {time_s[-1]:.3f} s and drives from {first:.3f} to {last:.3f} s: "
            "the two clocks do not overlap"
        )
    if held:
        middle = np.nanmedian(markers_m, axis=(0, 1))
        apart = min(float(np.linalg.norm(track.position_m - middle, axis=1).min()) for track in drives.values())
        if apart > 3 * size + 1.0:
            raise BadInput(
                f"{folder / 'drives.parquet'}: the drives stay {apart:.3g} m away from a held cloth of {size:.3g} m; "
                "are they in millimetres or in another frame?"
            )


def write_bundle(folder: Path, bundle: Bundle) -> None:
    """Write a bundle into `folder` (made if missing)."""
    folder.mkdir(parents=True, exist_ok=True)
    document = Document.model_validate(
        {
            "schema": SCHEMA,
            "garment": {"mesh": "garment.obj", "prior": bundle.prior},
            "environment": bundle.environment,
            "markers": {"noise_std_m": bundle.noise_std_m},
            "recordings": [
                {
                    "name": recording.name,
                    "starts": recording.starts,
                    "holds": [_hold_part(hold) for hold in recording.holds],
                }
                for recording in bundle.recordings
            ],
        }
    )
    write_document(folder / "bundle.yaml", document)
    write_mesh(folder / "garment.obj", bundle.mesh)
    write_anchors(folder / "anchors.parquet", bundle.anchors)
    for recording in bundle.recordings:
        place = folder / "recordings" / recording.name
        place.mkdir(parents=True, exist_ok=True)
        write_markers(place / "markers.parquet", bundle.anchors.marker, recording.time_s, recording.markers_m)
        write_drives(place / "drives.parquet", recording.drives)


def _hold_part(hold: Hold) -> HoldPart:
    places = None if hold.places_m is None else [tuple(float(x) for x in row) for row in hold.places_m]
    return HoldPart(
        drive=hold.drive, vertices=[int(v) for v in hold.vertices], from_s=hold.from_s, to_s=hold.to_s, places_m=places
    )
