"""From the files of a lab and its `import.yaml` to a bundle in memory."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.importing.anchors import anchors_of, label_ids
from sim1.recording.importing.c3d_file import read_c3d
from sim1.recording.importing.drive_table import read_drive_table
from sim1.recording.importing.import_file import Frame, ImportFile, RecordingSource
from sim1.recording.importing.lerobot import read_lerobot_drives
from sim1.recording.importing.long_csv import read_long
from sim1.recording.importing.motive_csv import read_motive
from sim1.recording.importing.nexus_csv import read_nexus
from sim1.recording.importing.npz_file import read_npz, read_npz_drives
from sim1.recording.importing.paths import MarkerPaths
from sim1.recording.mesh import read_mesh
from sim1.recording.streams import FARTHEST_M, Anchors, Track
from sim1.scan.garment_file import METRES_PER_UNIT
from sim1.stage import BadInput

READERS = {"motive": read_motive, "nexus": read_nexus, "csv": read_long, "c3d": read_c3d, "npz": read_npz}
KINDS = (*READERS, "lerobot")


@dataclass(frozen=True, kw_only=True)
class Sources:
    """Where the recordings of one import come from."""

    import_file: Path
    document: ImportFile
    markers: dict[str, tuple[str, Path]]  # recording -> kind and file
    dataset: Path | None  # LeRobot dataset of the command line
    robot: Path | None  # folder of the robot that recorded it
    units: str | None  # of the command line
    up: str | None


def pair_files(
    kind: str, files: list[Path], import_file: Path, document: ImportFile
) -> tuple[dict[str, tuple[str, Path]], Path | None]:
    """Marker file of each recording, and the dataset where one was given.

    Raises:
        BadInput: a recording without a file or with two, a file without a recording, an unknown kind.
    """
    if kind not in KINDS:
        raise BadInput(f"kind {kind!r} is unknown; expected one of {', '.join(KINDS)}")
    if kind == "lerobot" and len(files) != 1:
        raise BadInput(f"kind lerobot takes one dataset folder, got {len(files)}")
    given = {} if kind == "lerobot" else {path.stem: path for path in files}
    if len(given) < len(files) and kind != "lerobot":
        raise BadInput(
            f"{files[0].parent}: two of the files have one name less ending; a recording is named after its file"
        )
    if strange := sorted(set(given) - set(document.recordings)):
        raise BadInput(
            f"{import_file}: recordings has {sorted(document.recordings)}, and {given[strange[0]]} is none of them; "
            "name each recording after its file, less the ending"
        )
    paired = {}
    for name, part in document.recordings.items():
        if (name in given) == (part.markers is not None):
            raise BadInput(
                f"{import_file}: recordings.{name}: its markers are given {'twice' if name in given else 'nowhere'}; "
                f"give a file {name}.* on the command line, or markers: {{kind, file}} here"
            )
        paired[name] = (
            (kind, given[name]) if name in given else (part.markers.kind, import_file.parent / part.markers.file)
        )
    return paired, files[0] if kind == "lerobot" else None


def assemble(sources: Sources) -> tuple[Bundle, list[str]]:
    """The bundle, and labels of the files that are not on the cloth.

    Raises:
        BadInput: a file is damaged, or the files do not fit together; names the file, the place, the value and the remedy.
    """
    document, place = sources.document, sources.import_file
    mesh = read_mesh(place.parent / document.garment.mesh, METRES_PER_UNIT[document.garment.units])
    paths = {name: _read_markers(sources, *found) for name, found in sources.markers.items()}
    labels = {label for path in paths.values() for label in path.labels}
    ids = label_ids(place, document, labels)
    anchors = anchors_of(place, document, ids, mesh)
    recordings = tuple(_recording(sources, name, paths[name], ids, anchors) for name in document.recordings)
    bundle = Bundle(
        mesh=mesh,
        prior=document.garment.prior,
        environment=document.environment,
        noise_std_m=document.markers.noise_std_m,
        anchors=anchors,
        recordings=recordings,
    )
    return bundle, sorted(labels - set(ids))


def _read_markers(sources: Sources, kind: str, file: Path) -> MarkerPaths:
    of_document = sources.document.markers
    return READERS[kind](file, sources.units or of_document.units, sources.up or of_document.up)


def _recording(sources: Sources, name: str, paths: MarkerPaths, ids: dict[str, int], anchors: Anchors) -> Recording:
    part, file = sources.document.recordings[name], sources.markers[name][1]
    positions = _in_order(file, paths, ids, anchors)
    positions = _to_world(positions, sources.document.markers.to_world)
    time, drives = paths.time_s, _drives(sources, name, part)
    if part.cut_s is not None:
        kept = (time >= part.cut_s[0]) & (time <= part.cut_s[1])
        if kept.sum() < 3:
            raise BadInput(
                f"{sources.import_file}: recordings.{name}.cut_s is {list(part.cut_s)}, and {file} runs from {time[0]:.3f} to "
                f"{time[-1]:.3f} s; fewer than 3 frames are left"
            )
        time, positions = time[kept], positions[kept]
        drives = {drive: _cut(track, *part.cut_s) for drive, track in drives.items()}
    holds = []
    for hold in part.holds:
        if hold.drive not in drives:
            raise BadInput(
                f"{sources.import_file}: recordings.{name}: a hold names drive {hold.drive!r}; there are {sorted(drives)}"
            )
        first, last = drives[hold.drive].time_s[[0, -1]]
        holds.append(
            Hold(
                drive=hold.drive,
                vertices=np.array(hold.vertices),
                from_s=float(first) if hold.from_s is None else hold.from_s,
                to_s=float(last) if hold.to_s is None else hold.to_s,
                places_m=None if hold.places_m is None else np.array(hold.places_m, float),
            )
        )
    return Recording(name=name, starts=part.starts, holds=tuple(holds), time_s=time, markers_m=positions, drives=drives)


def _in_order(file: Path, paths: MarkerPaths, ids: dict[str, int], anchors: Anchors) -> np.ndarray:
    """Positions (T, M, 3) of the markers on the cloth, in the order of the anchors."""
    label_of = {marker: label for label, marker in ids.items()}
    columns = []
    for marker in anchors.marker:
        label = label_of[int(marker)]
        if (count := paths.labels.count(label)) != 1:
            found = (
                "occurs more than once" if count else f"is not there; its labels are {sorted(set(paths.labels))[:12]}"
            )
            raise BadInput(f"{file}: marker {label!r} {found}; correct the labels, or markers.labels in import.yaml")
        columns.append(paths.labels.index(label))
    chosen = paths.positions_m[:, columns]
    if (far := np.abs(np.nan_to_num(chosen)) > FARTHEST_M).any():
        frame, column = np.argwhere(far)[0][:2]
        raise BadInput(
            f"{file}: at {paths.time_s[frame]} s marker {paths.labels[columns[column]]!r} is at {chosen[frame, column].tolist()} m; "
            "is the unit of length right, or are these millimetres?"
        )
    return chosen


def _to_world(positions: np.ndarray, frame: Frame) -> np.ndarray:
    turn = Rotation.from_quat(frame.rotation_wxyz, scalar_first=True).as_matrix()
    return positions @ turn.T + np.array(frame.shift_m)


def _drives(sources: Sources, name: str, part: RecordingSource) -> dict[str, Track]:
    source, folder = part.drives, sources.import_file.parent
    own = None if source.file is None else folder / source.file
    if source.kind == "csv":
        drives = read_drive_table(own)
    elif source.kind == "npz":
        kind, file = sources.markers[name]
        if own is None and kind != "npz":
            raise BadInput(
                f"{sources.import_file}: recordings.{name}.drives.file is missing; name the archive of the drives"
            )
        drives = read_npz_drives(own or file)
        if not drives:
            raise BadInput(f"{own or file}: no drives; expected keys drive_NAME_time_s, drive_NAME_position_m, ...")
    else:
        dataset = own or sources.dataset
        if dataset is None or sources.robot is None:
            raise BadInput(
                f"{sources.import_file}: recordings.{name}.drives: name the dataset as file (and the robot with --robot)"
            )
        drives = read_lerobot_drives(dataset, source.episode or 0, sources.robot, source.use)
    return {drive: _shifted(track, source.shift_s) for drive, track in drives.items()}


def _shifted(track: Track, shift_s: float) -> Track:
    return Track(
        time_s=track.time_s + shift_s,
        position_m=track.position_m,
        rotation_wxyz=track.rotation_wxyz,
        openness=track.openness,
    )


def _cut(track: Track, from_s: float, to_s: float) -> Track:
    """The track from the last sample before to the first after, so that it covers the time between."""
    first = max(int(np.searchsorted(track.time_s, from_s, side="right")) - 1, 0)
    last = min(int(np.searchsorted(track.time_s, to_s)) + 1, len(track.time_s))
    kept = slice(first, max(last, first + 2))
    return Track(
        time_s=track.time_s[kept],
        position_m=track.position_m[kept],
        rotation_wxyz=track.rotation_wxyz[kept],
        openness=track.openness[kept],
    )
