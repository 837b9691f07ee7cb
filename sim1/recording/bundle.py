"""Recording bundles, format `sim1.recordings/1`: what a lab hands over, read strictly and written back.

SI units, right-handed frame, z up. A bundle that reads without an error is consistent: every index, clock and unit was checked.
"""

from pathlib import Path

import numpy as np

from sim1.recording.consistency import Seen, check_clocks, check_folders, check_frames, check_holds, check_lengths
from sim1.recording.document import (
    SCHEMA,
    Document,
    HoldPart,
    RecordingPart,
    read_document,
    write_document,
)
from sim1.recording.mesh import RestMesh, read_mesh, write_mesh
from sim1.recording.problems import Problems
from sim1.recording.recorded import Bundle, Hold, Recording
from sim1.recording.starts import check_start
from sim1.recording.streams import (
    Anchors,
    read_anchors,
    read_drives,
    read_markers,
    write_anchors,
    write_drives,
    write_markers,
)
from sim1.stage import BadInput

NO_MESH = 2**31  # faces, where the mesh does not read: its anchors are then checked for all but the face


def read_bundle(folder: Path) -> Bundle:
    """Read and check a bundle.

    Raises:
        BadInput: anything missing, damaged or inconsistent; names the file, the row, the value and the remedy.
    """
    problems = Problems()
    bundle = _read(folder, problems)
    problems.stop()
    assert bundle is not None  # without a problem there is a bundle
    return bundle


def examine_bundle(folder: Path) -> tuple[Bundle | None, tuple[str, ...]]:
    """The bundle, or None, and all that is wrong with it: the first problem of each file, and all of bundle.yaml's."""
    problems = Problems()
    bundle = problems.attempt(_read, folder, problems)
    return (None if problems.found else bundle), tuple(problems.found)


def _read(folder: Path, problems: Problems) -> Bundle | None:
    if not folder.is_dir():
        raise BadInput(f"{folder}: not a folder; expected a recording bundle with bundle.yaml, schema {SCHEMA}")
    document = read_document(folder / "bundle.yaml")
    problems.attempt(check_folders, folder, document)
    mesh = problems.attempt(read_mesh, folder / document.garment.mesh)
    face_count = len(mesh.faces) if mesh else NO_MESH
    anchors = problems.attempt(read_anchors, folder / "anchors.parquet", face_count)
    recordings = [_read_recording(folder, part, document, mesh, anchors, problems) for part in document.recordings]
    if mesh is None or anchors is None or problems.found:
        return None
    return Bundle(
        mesh=mesh,
        prior=document.garment.prior,
        environment=document.environment,
        noise_std_m=document.markers.noise_std_m,
        anchors=anchors,
        recordings=tuple(recording for recording in recordings if recording is not None),
        folder=folder,
    )


def _read_recording(
    folder: Path,
    part: RecordingPart,
    document: Document,
    mesh: RestMesh | None,
    anchors: Anchors | None,
    problems: Problems,
) -> Recording | None:
    place = folder / "recordings" / part.name
    drives = problems.attempt(read_drives, place / "drives.parquet")
    if drives is not None and mesh is not None:
        problems.attempt(check_holds, folder / "bundle.yaml", part.name, part.holds, drives, mesh)
    markers = None if anchors is None else problems.attempt(read_markers, place / "markers.parquet", anchors.marker)
    if mesh is None or drives is None or anchors is None or markers is None:
        return None
    time_s, markers_m = markers
    seen = Seen(folder=place, marker=anchors.marker, time_s=time_s, markers_m=markers_m)
    problems.attempt(check_clocks, seen, drives)
    problems.attempt(check_lengths, seen, mesh, anchors)
    problems.attempt(check_frames, seen, document.environment, mesh, drives, bool(part.holds))
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
    recording = Recording(
        name=part.name, starts=part.starts, holds=holds, time_s=time_s, markers_m=markers_m, drives=drives
    )
    problems.attempt(check_start, place, recording)
    return recording


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
