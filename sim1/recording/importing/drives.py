"""Drives of a recording from wherever `import.yaml` says that they are, on the markers' clock."""

from dataclasses import replace

import numpy as np

from sim1.recording.importing.drive_table import read_drive_table
from sim1.recording.importing.lerobot import read_lerobot_drives
from sim1.recording.importing.npz_file import read_npz_drives
from sim1.recording.importing.sources import Sources
from sim1.recording.places import Places
from sim1.recording.streams import Drives, Track
from sim1.stage import BadInput


def read_drives_of(sources: Sources, name: str) -> Drives:
    """Drives of one recording, shifted onto the clock of its markers.

    Raises:
        BadInput: nobody says where they are, or they are damaged there.
    """
    source, folder = sources.document.recordings[name].drives, sources.import_file.parent
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
        if not drives.tracks:
            raise BadInput(f"{own or file}: no drives; expected keys drive_NAME_time_s, drive_NAME_position_m, ...")
    else:
        dataset = own or sources.dataset
        if dataset is None or sources.robot is None:
            raise BadInput(
                f"{sources.import_file}: recordings.{name}.drives: name the dataset as file (and the robot with --robot)"
            )
        drives = read_lerobot_drives(dataset, source.episode or 0, sources.robot, source.use)
    tracks = drives.tracks.items()
    return replace(
        drives, tracks={drive: replace(track, time_s=track.time_s + source.shift_s) for drive, track in tracks}
    )


def cut_drives(drives: Drives, from_s: float, to_s: float) -> Drives:
    """The drives from the last sample before to the first after, so that they cover the time between where they can."""
    kept = {drive: _kept(track.time_s, from_s, to_s) for drive, track in drives.tracks.items()}
    return replace(
        drives,
        tracks={drive: _cut(track, kept[drive]) for drive, track in drives.tracks.items()},
        rows={drive: rows[kept[drive]] for drive, rows in drives.rows.items()},
    )


def drive_places(drives: Drives) -> Places:
    """Where the rows of the bundle's table stand in the lab's file: drives one after the other in order of name."""
    samples = [(name, k) for name in sorted(drives.tracks) for k in range(len(drives.tracks[name].time_s))]
    return Places(file=drives.places.file, row=lambda row: drives.place(*samples[row]))


def _kept(time_s: np.ndarray, from_s: float, to_s: float) -> slice:
    """Two samples at least: drives that are elsewhere in time are then found to be."""
    first = max(int(np.searchsorted(time_s, from_s, side="right")) - 1, 0)
    last = min(int(np.searchsorted(time_s, to_s)) + 1, len(time_s))
    first = min(first, len(time_s) - 2)
    return slice(first, max(last, first + 2))


def _cut(track: Track, kept: slice) -> Track:
    return Track(
        time_s=track.time_s[kept],
        position_m=track.position_m[kept],
        rotation_wxyz=track.rotation_wxyz[kept],
        openness=track.openness[kept],
    )
