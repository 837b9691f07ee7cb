"""What the files of a bundle say about each other: clocks, lengths, folders, holds."""

from pathlib import Path

import numpy as np

from sim1.recording.document import Document, HoldPart
from sim1.recording.mesh import RestMesh
from sim1.recording.streams import Anchors, Drives, Seen
from sim1.stage import BadInput

CLOCK_SLACK_S = 0.1  # a hold may be stamped by a rounded time
UNCOVERED_S = 0.5  # clocks that differ by as much are a mismatch to be found, not a damaged file
STRETCHED = 1.3  # markers farther apart than the mesh allows: woven cloth tears before
SHRUNK = 0.05  # of the span of their anchors: no cloth is ever crumpled so small from first frame to last
BELOW_TABLE_M = 0.1
FEWEST_SEEN = 3  # markers of a frame whose span says something: two may be folded onto each other
FEWEST_PAIRS, FEWEST_FRAMES = 3, 3  # of markers seen together: one pair may be a mistake of the cameras


def check_folders(folder: Path, document: Document) -> None:
    """Check that each folder of `recordings/` is listed.

    Raises:
        BadInput: one is not.
    """
    listed = {part.name for part in document.recordings}
    place = folder / "recordings"
    found = {path.name for path in place.iterdir() if path.is_dir()} if place.is_dir() else set()
    if extra := sorted(name for name in found - listed if not name.startswith(".")):
        raise BadInput(
            f"{folder / 'bundle.yaml'}: recordings: the folder recordings/{extra[0]} is not listed "
            f"({len(extra)} such); list it, or move it out of the bundle"
        )


def check_holds(path: Path, name: str, holds: list[HoldPart], drives: Drives, mesh: RestMesh) -> None:
    """Check the holds of one recording against its drives and the mesh; `path` is the file that says them.

    Raises:
        BadInput: an unknown drive or vertex, a time outside the drive's path, places that do not fit the mesh.
    """
    size = mesh_size_m(mesh)
    for hold in holds:
        place = f"{path}: recording {name}: hold of drive {hold.drive!r}"
        if hold.drive not in drives.tracks:
            raise BadInput(f"{place}: {drives.places.file} has {sorted(drives.tracks)}; name one of them")
        if max(hold.vertices) >= len(mesh.vertices_m):
            raise BadInput(
                f"{place}: vertex {max(hold.vertices)} is unknown; the mesh has {len(mesh.vertices_m)}, counted from 0"
            )
        first, last = drives.tracks[hold.drive].time_s[[0, -1]]
        if hold.from_s < first - CLOCK_SLACK_S or hold.to_s > last + CLOCK_SLACK_S:
            raise BadInput(
                f"{place}: {hold.from_s} to {hold.to_s} s lies outside the recording ({first:.3f} to {last:.3f} s of the drive)"
            )
        spread = float(np.linalg.norm(np.ptp(np.array(hold.places_m or [[0, 0, 0]], float), axis=0)))
        if spread > 1.5 * size + 0.02:
            raise BadInput(
                f"{place}: places_m span {spread:.3g} m on a cloth of {size:.3g} m; expected metres in the drive's frame"
            )


def check_clocks(seen: Seen, drives: Drives) -> None:
    """Check that every drive covers the markers' time.

    Raises:
        BadInput: the clocks do not overlap, or a drive starts after the markers or ends before them.
    """
    begin, end = seen.time_s[[0, -1]]
    for name, track in sorted(drives.tracks.items()):
        first, last = track.time_s[[0, -1]]
        ranges = f"markers run from {begin:.3f} to {end:.3f} s and drive {name!r} from {first:.3f} to {last:.3f} s"
        if begin > last or end < first:
            raise BadInput(
                f"{seen.places.file}: {ranges} ({drives.places.file}): the two clocks do not overlap; shift one stream by a constant, "
                "or pair the files of one recording"
            )
        if first > begin + UNCOVERED_S or last < end - UNCOVERED_S:
            raise BadInput(
                f"{drives.places.file}: {ranges}: the drive is shorter than the markers; "
                "cut the markers, or record the drive throughout"
            )


def check_lengths(seen: Seen, mesh: RestMesh, anchors: Anchors) -> None:
    """Check that the markers are as far from each other as the mesh lets them be.

    Raises:
        BadInput: another unit, another mesh, a marker mislabelled.
    """
    size = mesh_size_m(mesh)
    places = _places_m(mesh, anchors)
    shares = []  # of their anchors' span that the markers of a frame span
    for frame, points in enumerate(seen.markers_m):
        there = np.isfinite(points[:, 0])
        if there.sum() < 2:
            continue
        span = float(np.linalg.norm(np.ptp(points[there], axis=0)))
        if span > 1.5 * size + 0.05:
            raise BadInput(
                f"{seen.place(frame)}: at {seen.time_s[frame]} s the markers span {span:.3g} m on a cloth of {size:.3g} m; "
                "are they in millimetres, is a marker mislabelled, or are gaps written as zeros?"
            )
        if there.sum() >= FEWEST_SEEN:
            shares.append(span / float(np.linalg.norm(np.ptp(places[there], axis=0))))
    if shares and (widest := max(shares)) < SHRUNK:
        raise BadInput(
            f"{seen.places.file}: markers never span more than {widest:.3g} of what their anchors on the mesh do; "
            "are they in metres and said to be in millimetres, or is the mesh of another unit?"
        )
    if (ratio := stretch(mesh, anchors, seen.markers_m)) is not None and ratio > STRETCHED:
        raise BadInput(
            f"{seen.places.file}: markers are {ratio:.3g} times as far apart as their anchors on the mesh (median of pairs); "
            "the mesh has another size or unit, or the anchors belong to other markers"
        )


def check_frames(seen: Seen, document: Document, path: Path, mesh: RestMesh, drives: Drives, held: bool) -> None:
    """Check that markers, drives and table can be in one frame; `path` is the file that says `document`.

    Raises:
        BadInput: a held cloth far from all drives, a marker far from the others, a cloth far below the table.
    """
    size = mesh_size_m(mesh)
    middle = np.nanmedian(seen.markers_m, axis=(0, 1))
    ways = {name: np.linalg.norm(track.position_m - middle, axis=1) for name, track in drives.tracks.items()}
    apart, nearest = min((float(way.min()), name) for name, way in ways.items())
    if held and apart > 3 * size + 1.0:
        raise BadInput(
            f"{drives.place(nearest, int(ways[nearest].argmin()))}: the drives stay {apart:.3g} m away from a held cloth of "
            f"{size:.3g} m, here they come nearest; are they in millimetres or in another frame?"
        )
    away = np.linalg.norm(seen.markers_m - middle, axis=2)
    travel = max(float(np.linalg.norm(np.ptp(track.position_m, axis=0))) for track in drives.tracks.values())
    if held and np.nanmax(away) > 3 * size + 1.0 + travel:
        frame, column = np.unravel_index(np.nanargmax(away), away.shape)
        raise BadInput(
            f"{seen.place(frame, column)}: at {seen.time_s[frame]} s marker {seen.marker[column]} is {away[frame, column]:.3g} m away from "
            f"where the cloth is, at {seen.markers_m[frame, column].tolist()}; set visible=false where it was not tracked"
        )
    table = document.environment.table
    if table is not None and middle[2] < table.height_m - BELOW_TABLE_M:
        raise BadInput(
            f"{seen.places.file}: the cloth is {table.height_m - middle[2]:.3g} m below the table at "
            f"{table.height_m} m ({path.name}: environment.table.height_m); is z up, and is it the same frame?"
        )


def mesh_size_m(mesh: RestMesh) -> float:
    """Diagonal of the mesh's box."""
    return float(np.linalg.norm(np.ptp(mesh.vertices_m, axis=0)))


def stretch(mesh: RestMesh, anchors: Anchors, markers_m: np.ndarray) -> float | None:
    """How many times as far apart as on a flat mesh the markers (T, M, 3) are, median over pairs and frames.

    None where it does not say anything: fewer than two markers, a mesh that is not flat (a straight line through the air
    is shorter than the way over the cloth), too few pairs seen together.
    """
    extent = np.linalg.svd(mesh.vertices_m - mesh.vertices_m.mean(0), compute_uv=False)
    if len(anchors.marker) < 2 or extent[2] > 0.01 * extent[0]:
        return None
    places = _places_m(mesh, anchors)
    a, b = np.triu_indices(len(places), 1)
    rest = np.linalg.norm(places[a] - places[b], axis=1)
    far = np.argsort(-rest)[:300]  # long pairs: noise is nothing beside them
    far = far[rest[far] > max(0.2 * rest.max(), 1e-6)]
    every = max(1, len(markers_m) // 200)
    now = np.linalg.norm(markers_m[::every, a[far]] - markers_m[::every, b[far]], axis=2)
    together = np.isfinite(now).sum(0) >= FEWEST_FRAMES
    if together.sum() < FEWEST_PAIRS:
        return None
    return float(np.median(np.nanmedian(now[:, together], axis=0) / rest[far][together]))


def _places_m(mesh: RestMesh, anchors: Anchors) -> np.ndarray:
    """Where the markers are on the rest mesh, (M, 3)."""
    return (mesh.vertices_m[mesh.faces[anchors.face]] * anchors.weight[..., None]).sum(1)
