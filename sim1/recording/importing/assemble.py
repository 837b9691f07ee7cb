"""From the files of a lab and its `import.yaml` to a bundle in memory, and where in them everything stands."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.clocks import check_forward
from sim1.recording.importing.anchors import anchors_of, label_ids
from sim1.recording.importing.c3d_file import read_c3d
from sim1.recording.importing.drives import cut_drives, drive_places, read_drives_of
from sim1.recording.importing.import_file import Frame, RecordingSource
from sim1.recording.importing.long_csv import read_long
from sim1.recording.importing.motive_csv import read_motive
from sim1.recording.importing.nexus_csv import read_nexus
from sim1.recording.importing.npz_file import read_npz
from sim1.recording.importing.paths import MarkerPaths, marker_places
from sim1.recording.importing.sources import Sources
from sim1.recording.mesh import read_mesh
from sim1.recording.places import ANCHORS, DOCUMENT, MESH, Places, own_places, stream
from sim1.recording.streams import FARTHEST_M, Anchors, Drives
from sim1.scan.garment_file import METRES_PER_UNIT
from sim1.stage import BadInput

READERS = {"motive": read_motive, "nexus": read_nexus, "csv": read_long, "c3d": read_c3d, "npz": read_npz}


@dataclass(frozen=True, kw_only=True)
class Assembled:
    """A bundle from the files of a lab."""

    bundle: Bundle
    places: dict[str, Places]  # in the lab's files, by path in the bundle
    left_out: list[str]  # labels that are not on the cloth


def assemble(sources: Sources) -> Assembled:
    """The bundle, not yet checked as a whole.

    Raises:
        BadInput: a file is damaged, or the files do not fit together; names the file, the place, the value and the remedy.
    """
    document, place = sources.document, sources.import_file
    mesh_file = place.parent / document.garment.mesh
    mesh = read_mesh(mesh_file, METRES_PER_UNIT[document.garment.units])
    paths = {name: _read_markers(sources, *found) for name, found in sources.markers.items()}
    labels = {label for path in paths.values() for label in path.labels}
    ids = label_ids(place, document, labels)
    anchors, of_anchors = anchors_of(place, document, ids, mesh)
    places = {DOCUMENT: own_places(place), MESH: own_places(mesh_file), ANCHORS: of_anchors}
    recordings = []
    for name, part in document.recordings.items():
        markers, drives = _on_the_cloth(paths[name], ids, anchors), read_drives_of(sources, name)
        markers = replace(markers, positions_m=_to_world(markers.positions_m, document.markers.to_world))
        if part.cut_s is not None:
            markers, drives = _cut(place, name, part.cut_s, markers), cut_drives(drives, *part.cut_s)
        recordings.append(_recording(place, name, part, markers, drives))
        places |= {stream(name, "markers"): marker_places(markers), stream(name, "drives"): drive_places(drives)}
    bundle = Bundle(
        mesh=mesh,
        prior=document.garment.prior,
        environment=document.environment,
        noise_std_m=document.markers.noise_std_m,
        anchors=anchors,
        recordings=tuple(recordings),
    )
    return Assembled(bundle=bundle, places=places, left_out=sorted(labels - set(ids)))


def _read_markers(sources: Sources, kind: str, file: Path) -> MarkerPaths:
    of_document = sources.document.markers
    return READERS[kind](file, sources.units or of_document.units, sources.up or of_document.up)


def _on_the_cloth(paths: MarkerPaths, ids: dict[str, int], anchors: Anchors) -> MarkerPaths:
    """The markers on the cloth alone, in the order of the anchors."""
    label_of = {marker: label for label, marker in ids.items()}
    columns = []
    for marker in anchors.marker:
        label = label_of[int(marker)]
        if (count := paths.labels.count(label)) != 1:
            found = (
                "occurs more than once" if count else f"is not there; its labels are {sorted(set(paths.labels))[:12]}"
            )
            raise BadInput(
                f"{paths.file}: marker {label!r} {found}; correct the labels, or markers.labels in import.yaml"
            )
        columns.append(paths.labels.index(label))
    chosen = replace(
        paths,
        labels=tuple(paths.labels[column] for column in columns),
        positions_m=paths.positions_m[:, columns],
        rows=paths.rows[:, columns],
    )
    check_forward(chosen.place, chosen.time_s)
    if (far := np.abs(np.nan_to_num(chosen.positions_m)) > FARTHEST_M).any():
        frame, column = np.argwhere(far)[0][:2]
        raise BadInput(
            f"{chosen.place(frame, column)}: at {chosen.time_s[frame]} s marker {chosen.labels[column]!r} is at "
            f"{chosen.positions_m[frame, column].tolist()} m; is the unit of length right, or are these millimetres?"
        )
    return chosen


def _to_world(positions: np.ndarray, frame: Frame) -> np.ndarray:
    turn = Rotation.from_quat(frame.rotation_wxyz, scalar_first=True).as_matrix()
    return positions @ turn.T + np.array(frame.shift_m)


def _cut(import_file: Path, name: str, cut_s: tuple[float, float], paths: MarkerPaths) -> MarkerPaths:
    time = paths.time_s
    kept = (time >= cut_s[0]) & (time <= cut_s[1])
    if kept.sum() < 3:
        raise BadInput(
            f"{import_file}: recordings.{name}.cut_s is {list(cut_s)}, and {paths.file} runs from {time[0]:.3f} to "
            f"{time[-1]:.3f} s; fewer than 3 frames are left"
        )
    return replace(paths, time_s=time[kept], positions_m=paths.positions_m[kept], rows=paths.rows[kept])


def _recording(import_file: Path, name: str, part: RecordingSource, paths: MarkerPaths, drives: Drives) -> Recording:
    holds = []
    for hold in part.holds:
        if hold.drive not in drives.tracks:
            raise BadInput(
                f"{import_file}: recordings.{name}: a hold names drive {hold.drive!r}; there are {sorted(drives.tracks)} in "
                f"{drives.places.file}"
            )
        first, last = drives.tracks[hold.drive].time_s[[0, -1]]
        holds.append(
            Hold(
                drive=hold.drive,
                vertices=np.array(hold.vertices),
                from_s=float(first) if hold.from_s is None else hold.from_s,
                to_s=float(last) if hold.to_s is None else hold.to_s,
                places_m=None if hold.places_m is None else np.array(hold.places_m, float),
            )
        )
    return Recording(
        name=name,
        starts=part.starts,
        holds=tuple(holds),
        time_s=paths.time_s,
        markers_m=paths.positions_m,
        drives=drives.tracks,
    )
