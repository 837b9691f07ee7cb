"""A recording made ready to be simulated again and again in other worlds."""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, RBFInterpolator
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation, Slerp

from sim1.cloth.precise.arrays import Net
from sim1.cloth.precise.mesh import Sheet, narrow, place_on, refined, reordered
from sim1.cloth.precise.world import World
from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.motion import rest_until_s
from sim1.recording.streams import Track
from sim1.stage import BadInput

AFTER_S = 0.15  # simulated beyond the last frame, for clocks that differ


@dataclass(frozen=True, kw_only=True)
class Grip:
    """One hold of a recording on the simulated mesh."""

    drive: str
    vertices: np.ndarray  # (h,)
    places_m: np.ndarray  # (h, 3) in the drive's frame
    position_m: np.ndarray  # (T, 3) of the drive at the steps
    turn: np.ndarray  # (T, 3, 3)
    active: np.ndarray  # (T,) whether it holds
    index: int  # which of the world's `places` belongs to it


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Mesh, grips, times and the start of one recording at one resolution."""

    name: str
    sheet: Sheet
    net: Net
    grips: tuple[Grip, ...]
    step_s: float
    time_s: np.ndarray  # (T,)
    frame_s: np.ndarray  # (N,) times of the markers' frames on their own clock
    start: np.ndarray  # (V, 3) shape near which it rests
    start_velocity: np.ndarray | None  # (V, 3); None: it starts at rest
    clamped: np.ndarray  # (C,) stencils on the rim of a clamp
    rim: np.ndarray  # (F,) faces there
    order: np.ndarray  # (V,) vertex of the bundle's (refined) mesh that each simulated vertex is

    def paths(self, world: World) -> np.ndarray:
        """Where the held vertices are wanted, (T, H, 3)."""
        parts = []
        for grip in self.grips:
            places = grip.places_m
            if world.places:
                shift, turn = np.array(world.places[grip.index][:3]), np.array(world.places[grip.index][3:])
                middle = places.mean(0)
                places = Rotation.from_rotvec(turn).apply(places - middle) + middle + shift
            path = grip.position_m[:, None] + np.einsum("tij,hj->thi", grip.turn, places)
            parts.append(_late(path, world.lag_s, self.step_s))
        return np.concatenate(parts, axis=1) if parts else np.zeros((len(self.time_s), 0, 3))

    def observed(self, markers: np.ndarray, world: World) -> np.ndarray:
        """Markers (T, M, 3) at the steps as the cameras report them, (N, M, 3)."""
        time = np.clip(self.frame_s - world.clock_offset_s, *self.time_s[[0, -1]])
        seen = CubicSpline(self.time_s, markers)(time)
        if any(world.frame_turn_rad) or any(world.frame_shift_m):
            seen = seen @ Rotation.from_rotvec(world.frame_turn_rad).as_matrix().T + np.array(world.frame_shift_m)
        return seen


def _late(path: np.ndarray, lag_s: float, step_s: float) -> np.ndarray:
    """A first-order lag, exact for commands that are linear between steps; the command rested before."""
    if lag_s <= 0.0:
        return path
    keep = np.exp(-step_s / lag_s)
    slope = np.diff(path, axis=0) / step_s
    drive = path[1:] - keep * path[:-1] - slope * lag_s * (1.0 - keep)
    first = path[0]
    late, _ = lfilter([1.0], [1.0, -keep], drive, axis=0, zi=(keep * first)[None])
    return np.concatenate([first[None], late])


def drive_pose(track: Track, time_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (T, 3) and rotation matrices (T, 3, 3) of a drive; constant outside its track."""
    time = np.clip(time_s, *track.time_s[[0, -1]])
    turn = Slerp(track.time_s, Rotation.from_quat(track.rotation_wxyz, scalar_first=True))(time).as_matrix()
    return CubicSpline(track.time_s, track.position_m)(time), turn


def sheet_of(bundle: Bundle) -> Sheet:
    """The bundle's rest mesh as a flat sheet.

    Raises:
        BadInput: the mesh has no material coordinates and is not flat.
    """
    if bundle.mesh.material_m is not None:
        return Sheet(material_m=bundle.mesh.material_m, faces=bundle.mesh.faces)
    middle = bundle.mesh.vertices_m.mean(0)
    _, size, axes = np.linalg.svd(bundle.mesh.vertices_m - middle, full_matrices=False)
    if size[2] > 1e-3 * size[0]:
        raise BadInput("garment.obj: no material coordinates on a mesh that is not flat; write them as `vt` in metres")
    return Sheet(material_m=(bundle.mesh.vertices_m - middle) @ axes[:2].T, faces=bundle.mesh.faces)


def hold_key(hold: Hold) -> tuple[str, tuple[int, ...]]:
    """What holds of several recordings share when their places are the same unknown."""
    return hold.drive, tuple(int(v) for v in hold.vertices)


def unknown_holds(bundle: Bundle) -> list[tuple[str, tuple[int, ...]]]:
    """Grips of the bundle, in the order of a world's `places`."""
    return sorted({hold_key(hold) for recording in bundle.recordings for hold in recording.holds})


def marker_points(bundle: Bundle) -> np.ndarray:
    """Material coordinates (M, 2) of the markers."""
    sheet = sheet_of(bundle)
    return (sheet.material_m[sheet.faces[bundle.anchors.face]] * bundle.anchors.weight[..., None]).sum(1)


def spread_over(points_m: np.ndarray, values: np.ndarray, at_m: np.ndarray) -> np.ndarray:
    """Values (M, 3) known at material points, smoothly everywhere (V, 3); what is NaN is left out.

    Raises:
        BadInput: fewer than 3 markers are known.
    """
    known = np.isfinite(values).all(1)
    if known.sum() < 3:
        raise BadInput(
            f"markers.parquet: only {known.sum()} markers are seen at the start; 3 or more tell how it hangs"
        )
    # A plane through all of them, and what is left spread between them: five points are too few to tell how a sheet curves.
    kernel = "thin_plate_spline" if known.sum() >= 6 else "linear"
    return RBFInterpolator(points_m[known], values[known], kernel=kernel, degree=1, smoothing=1e-7)(at_m)


def resting_markers(recording: Recording) -> np.ndarray:
    """Median place (M, 3) of each marker before anything moves; NaN where it was never seen then."""
    first = recording.time_s[0]
    until = rest_until_s(recording) if recording.starts == "rest" else first + 0.05
    rows = recording.time_s <= max(until, first + 0.05)
    out = np.full(recording.markers_m.shape[1:], np.nan)
    for m in range(out.shape[0]):
        seen = recording.markers_m[rows, m]
        seen = seen[np.isfinite(seen[:, 0])]
        if len(seen):
            out[m] = np.median(seen, axis=0)
    return out


def estimated_places(bundle: Bundle) -> dict[tuple[str, tuple[int, ...]], np.ndarray]:
    """Places of held vertices in their drive's frame where nobody measured them: the flat patch fitted to the resting markers."""
    sheet, points, found = sheet_of(bundle), marker_points(bundle), {}
    for recording in bundle.recordings:
        for hold in recording.holds:
            if hold.places_m is not None:
                found[hold_key(hold)] = [hold.places_m]
    for recording in bundle.recordings:
        if recording.starts != "rest":
            continue
        for hold in recording.holds:
            if hold_key(hold) in found and any(
                h.places_m is not None and hold_key(h) == hold_key(hold) for r in bundle.recordings for h in r.holds
            ):
                continue
            if hold.from_s > rest_until_s(recording) + 0.05:
                continue
            seen = spread_over(points, resting_markers(recording), sheet.material_m)[hold.vertices]
            position, turn = drive_pose(recording.drives[hold.drive], np.array([recording.time_s[0]]))
            local = (seen - position[0]) @ turn[0]
            flat = np.column_stack([sheet.material_m[hold.vertices], np.zeros(len(hold.vertices))])
            if len(flat) > 1:
                with warnings.catch_warnings():  # vertices on one line leave the turn about it open: any will do
                    warnings.simplefilter("ignore", UserWarning)
                    rotation, _ = Rotation.align_vectors(local - local.mean(0), flat - flat.mean(0))
                local = rotation.apply(flat - flat.mean(0)) + local.mean(0)
            found.setdefault(hold_key(hold), []).append(local)
    for recording in bundle.recordings:
        for hold in recording.holds:
            if hold_key(hold) not in found:
                raise BadInput(
                    f"bundle.yaml: recording {recording.name}: places_m of drive {hold.drive!r} is null and no recording starts at rest "
                    "in this grip; measure where the cloth sits in it"
                )
    return {key: np.mean(parts, axis=0) for key, parts in found.items()}


def prepare(
    bundle: Bundle, recording: Recording, step_s: float, finer: int = 0, frame_s: np.ndarray | None = None
) -> Scene:
    """Make a recording ready; `finer` is how often every face is cut into four, `frame_s` other times than the markers'.

    Raises:
        BadInput: the recording cannot be simulated; names what is missing.
    """
    sheet = sheet_of(bundle)
    points = marker_points(bundle)
    parents = [np.repeat(np.arange(len(sheet.material_m))[:, None], 2, axis=1)]
    for _ in range(finer):
        sheet, between = refined(sheet)
        parents.append(between)
    order = narrow(sheet)
    sheet, place = reordered(sheet, order)
    first = rest_until_s(recording) if recording.starts == "rest" else float(recording.time_s[0])
    frame_s = recording.time_s if frame_s is None else frame_s
    last = float(frame_s[-1]) + AFTER_S
    start = max(min(first, last - 5 * step_s), min(track.time_s[0] for track in recording.drives.values()))
    time = start + step_s * np.arange(int(np.ceil((last - start) / step_s)) + 1)
    places, keys = estimated_places(bundle), unknown_holds(bundle)
    grips = []
    for hold in recording.holds:
        vertices, local = _held(hold, places[hold_key(hold)], parents)
        position, turn = drive_pose(recording.drives[hold.drive], time)
        ends = recording.drives[hold.drive].time_s[-1]
        grips.append(
            Grip(
                drive=hold.drive,
                vertices=place[vertices],
                places_m=local,
                position_m=position,
                turn=turn,
                active=(time >= hold.from_s - 1e-9) & ((time <= hold.to_s + 1e-9) | (hold.to_s >= ends - 0.05)),
                index=keys.index(hold_key(hold)),
            )
        )
    face, weight = place_on(sheet, points)
    stencils, stars = sheet.stencils, [part.astype(np.int64) for part in sheet.stars]
    held = np.concatenate([grip.vertices for grip in grips]) if grips else np.zeros(0, int)
    owner = np.concatenate([np.full(len(grip.vertices), k) for k, grip in enumerate(grips)]) if grips else held
    net = Net(
        faces=sheet.faces.astype(np.int64),
        first=stencils.first.astype(np.int64),
        node=stencils.node.astype(np.int64),
        centre=stencils.centre.astype(np.int64),
        second=np.ascontiguousarray(stencils.second),
        slope=np.ascontiguousarray(stencils.slope),
        star_first=stars[0],
        star_face=stars[1],
        star_local=np.ascontiguousarray(stars[2]),
        ring_first=stars[3],
        ring_node=stars[4],
        held=held.astype(np.int64),
        grip=owner.astype(np.int64),
        marker_node=sheet.faces[face].astype(np.int64),
        marker_weight=np.ascontiguousarray(weight),
    )
    shape, velocity = _start(recording, points, sheet, bundle)
    return Scene(
        name=recording.name,
        sheet=sheet,
        net=net,
        grips=tuple(grips),
        step_s=step_s,
        time_s=time,
        frame_s=frame_s,
        start=shape,
        start_velocity=velocity,
        clamped=_clamped(net),
        rim=_rim(net),
        order=order,
    )


def _rim(net: Net) -> np.ndarray:
    """Faces (F,) with held and free corners."""
    held = np.zeros(len(net.star_first) - 1, bool)
    held[net.held] = True
    count = held[net.faces].sum(1)
    return (count > 0) & (count < 3)


def _clamped(net: Net) -> np.ndarray:
    """Stencils (C,) around a held vertex with held neighbours on one side and free ones on the other."""
    held = np.zeros(len(net.star_first) - 1, bool)
    held[net.held] = True
    found = []
    for c in range(len(net.first) - 1):
        nodes = net.node[net.first[c] : net.first[c + 1]]
        share = held[nodes].mean()
        found.append(held[net.centre[c]] and 0.5 < share < 1.0)
    return np.array(found)


def _held(hold: Hold, places_m: np.ndarray, parents: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the refined mesh whose parents are all held, and their places in the drive's frame."""
    known = {int(vertex): places_m[k] for k, vertex in enumerate(hold.vertices)}
    for between in parents[1:]:
        known = {
            vertex: (known[int(a)] + known[int(b)]) / 2
            for vertex, (a, b) in enumerate(between)
            if int(a) in known and int(b) in known
        }
    return np.array(list(known)), np.array(list(known.values()))


def _start(
    recording: Recording, points: np.ndarray, sheet: Sheet, bundle: Bundle
) -> tuple[np.ndarray, np.ndarray | None]:
    """Shape, and velocity where the recording starts in motion, both spread from the markers over the mesh."""
    if recording.starts == "rest":
        shape, velocity = spread_over(points, resting_markers(recording), sheet.material_m), None
    else:
        rows = recording.time_s <= recording.time_s[0] + 0.1
        time = recording.time_s[rows] - recording.time_s[0]
        places, speeds = np.full((2, *recording.markers_m.shape[1:]), np.nan)
        for m in range(len(places)):
            seen = np.isfinite(recording.markers_m[rows, m, 0])
            if seen.sum() >= 4:
                fit = np.polyfit(time[seen], recording.markers_m[rows, m][seen], 2 if seen.sum() >= 6 else 1)
                places[m], speeds[m] = fit[-1], fit[-2]
        shape, velocity = (spread_over(points, part, sheet.material_m) for part in (places, speeds))
    if bundle.environment.table is not None:
        shape[:, 2] = np.maximum(shape[:, 2], table_z(bundle))
    return shape, velocity


def table_z(bundle: Bundle) -> float:
    """Height at which the middle surface of a lying sheet rests, m."""
    table = bundle.environment.table
    return float(table.height_m + 0.5 * bundle.prior.thickness_m.value)
