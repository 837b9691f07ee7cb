"""Recording bundles, format `sim1.recordings/1`: what a lab hands over, read strictly and written back.

SI units, right-handed frame, z up. A bundle that reads without an error is consistent: every index, clock and unit was checked.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sim1.recording.consistency import check_clocks, check_folders, check_frames, check_holds, check_lengths
from sim1.recording.document import (
    SCHEMA,
    Document,
    HoldPart,
    RecordingPart,
    read_document,
    write_document,
)
from sim1.recording.mesh import RestMesh, read_mesh, write_mesh
from sim1.recording.places import ANCHORS, DOCUMENT, MESH, NOT_IMPORTED, BundleFiles, Places, stream
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


def read_bundle(folder: Path, imported: Mapping[str, Places] = NOT_IMPORTED) -> Bundle:
    """Read and check a bundle.

    Args:
        folder: the bundle.
        imported: by path in the bundle, what messages name instead: the files of the lab.

    Raises:
        BadInput: anything missing, damaged or inconsistent; names the file, the row, the value and the remedy.
    """
    problems = Problems()
    bundle = _read(BundleFiles(folder=folder, imported=imported), problems)
    problems.stop()
    assert bundle is not None  # without a problem there is a bundle
    return bundle


def examine_bundle(folder: Path) -> tuple[Bundle | None, tuple[str, ...]]:
    """The bundle, or None, and all that is wrong with it: the first problem of each file, and all of bundle.yaml's."""
    problems = Problems()
    bundle = problems.attempt(_read, BundleFiles(folder=folder), problems)
    return (None if problems.found else bundle), tuple(problems.found)


def _read(files: BundleFiles, problems: Problems) -> Bundle | None:
    folder = files.folder
    if not folder.is_dir():
        raise BadInput(f"{folder}: not a folder; expected a recording bundle with {DOCUMENT}, schema {SCHEMA}")
    document = read_document(folder / DOCUMENT, files.places(DOCUMENT).file)
    problems.attempt(check_folders, folder, document)
    name = document.garment.mesh
    mesh = problems.attempt(read_mesh, folder / name, 1.0, files.places(name).file)
    face_count = len(mesh.faces) if mesh else NO_MESH
    anchors = problems.attempt(read_anchors, folder / ANCHORS, face_count, files.places(ANCHORS))
    recordings = [_read_recording(files, part, document, mesh, anchors, problems) for part in document.recordings]
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
    files: BundleFiles,
    part: RecordingPart,
    document: Document,
    mesh: RestMesh | None,
    anchors: Anchors | None,
    problems: Problems,
) -> Recording | None:
    said_in = files.places(DOCUMENT).file
    name = stream(part.name, "drives")
    drives = problems.attempt(read_drives, files.folder / name, files.places(name))
    if drives is not None and mesh is not None:
        problems.attempt(check_holds, said_in, part.name, part.holds, drives, mesh)
    if anchors is None:
        return None
    name = stream(part.name, "markers")
    seen = problems.attempt(read_markers, files.folder / name, anchors.marker, files.places(name))
    if mesh is None or drives is None or seen is None:
        return None
    problems.attempt(check_clocks, seen, drives)
    problems.attempt(check_lengths, seen, mesh, anchors)
    problems.attempt(check_frames, seen, document, said_in, mesh, drives, bool(part.holds))
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
        name=part.name,
        starts=part.starts,
        holds=holds,
        time_s=seen.time_s,
        markers_m=seen.markers_m,
        drives=drives.tracks,
    )
    problems.attempt(check_start, said_in, recording, seen.place, drives.place)
    return recording


def write_bundle(folder: Path, bundle: Bundle) -> None:
    """Write a bundle into `folder` (made if missing)."""
    folder.mkdir(parents=True, exist_ok=True)
    document = Document.model_validate(
        {
            "schema": SCHEMA,
            "garment": {"mesh": MESH, "prior": bundle.prior},
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
    write_document(folder / DOCUMENT, document)
    write_mesh(folder / MESH, bundle.mesh)
    write_anchors(folder / ANCHORS, bundle.anchors)
    for recording in bundle.recordings:
        markers, drives = (folder / stream(recording.name, name) for name in ("markers", "drives"))
        markers.parent.mkdir(parents=True, exist_ok=True)
        write_markers(markers, bundle.anchors.marker, recording.time_s, recording.markers_m)
        write_drives(drives, recording.drives)


def _hold_part(hold: Hold) -> HoldPart:
    places = None if hold.places_m is None else [tuple(float(x) for x in row) for row in hold.places_m]
    return HoldPart(
        drive=hold.drive, vertices=[int(v) for v in hold.vertices], from_s=hold.from_s, to_s=hold.to_s, places_m=places
    )
