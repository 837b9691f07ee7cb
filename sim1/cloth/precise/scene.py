"""A recording made ready to be simulated again and again in other worlds."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from sim1.cloth.precise.arrays import Net
from sim1.cloth.precise.drives import drive_pose, lagging
from sim1.cloth.precise.held_places import held_places
from sim1.cloth.precise.material import marker_points, markers_on, sheet_of
from sim1.cloth.precise.mesh import Sheet, narrow, refined, reordered
from sim1.cloth.precise.pairs import pairs_of
from sim1.cloth.precise.start import start_of
from sim1.cloth.precise.world import World
from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.motion import rest_until_s

AFTER_S = 0.3  # simulated beyond the last frame, for clocks that differ


@dataclass(frozen=True, kw_only=True)
class Grip:
    """One hold of a recording on the simulated mesh."""

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
    place: np.ndarray  # (V,) where each vertex stands of the mesh as it was cut, before it was reordered
    between: (
        np.ndarray
    )  # (V, 2) the two vertices of the mesh before that cut, as that was cut, between which each of these lies

    def paths(self, world: World) -> np.ndarray:
        """Where the held vertices are wanted, (T, H, 3)."""
        parts = []
        for grip in self.grips:
            places = grip.places_m
            if world.places:
                shift, turn = np.array(world.places[grip.index][:3]), np.array(world.places[grip.index][3:])
                middle = places.mean(0)
                places = Rotation.from_rotvec(turn).apply(places - middle) + middle + shift
            position, turn = lagging(grip.position_m, grip.turn, world.lag_s, self.step_s)
            parts.append(position[:, None] + np.einsum("tij,hj->thi", turn, places))
        return np.concatenate(parts, axis=1) if parts else np.zeros((len(self.time_s), 0, 3))

    def begun(self, world: World) -> tuple[np.ndarray, np.ndarray]:
        """Shape and velocity (V, 3) of a recording that starts in motion, which its markers tell in the frame of the cameras."""
        turn = Rotation.from_rotvec(world.frame_turn_rad).as_matrix()
        return (self.start - np.array(world.frame_shift_m)) @ turn, self.start_velocity @ turn

    def observed(self, markers: np.ndarray, world: World) -> np.ndarray:
        """Markers (T, M, 3) at the steps as the cameras report them, (N, M, 3)."""
        time = np.clip(self.frame_s - world.clock_offset_s, *self.time_s[[0, -1]])
        seen = CubicSpline(self.time_s, markers)(time)
        if any(world.frame_turn_rad) or any(world.frame_shift_m):
            seen = seen @ Rotation.from_rotvec(world.frame_turn_rad).as_matrix().T + np.array(world.frame_shift_m)
        return seen


def prepare(
    bundle: Bundle, recording: Recording, step_s: float, finer: int = 0, frame_s: np.ndarray | None = None
) -> Scene:
    """Make a recording ready; `finer` is how often every face is cut into four, `frame_s` other times than the markers'.

    Raises:
        BadInput: the recording cannot be simulated; names what is missing.
    """
    sheet, points = sheet_of(bundle), marker_points(bundle)
    parents = [np.repeat(np.arange(len(sheet.material_m))[:, None], 2, axis=1)]
    for _ in range(finer):
        sheet, between = refined(sheet)
        parents.append(between)
    sheet, place = reordered(sheet, narrow(sheet))
    first = rest_until_s(recording) if recording.starts == "rest" else float(recording.time_s[0])
    frame_s = recording.time_s if frame_s is None else frame_s
    last = float(frame_s[-1]) + AFTER_S
    start = max(min(first, last - 5 * step_s), min(track.time_s[0] for track in recording.drives.values()))
    time = start + step_s * np.arange(int(np.ceil((last - start) / step_s)) + 1)
    held_in = held_places(bundle)
    grips = []
    for hold in recording.holds:
        key = held_in.key(recording, hold)
        vertices, local = _held(hold, held_in.places_m[key], parents)
        position, turn = drive_pose(recording.drives[hold.drive], time)
        ends = recording.drives[hold.drive].time_s[-1]
        grips.append(
            Grip(
                vertices=place[vertices],
                places_m=local,
                position_m=position,
                turn=turn,
                active=(time >= hold.from_s - 1e-9) & ((time <= hold.to_s + 1e-9) | (hold.to_s >= ends - 0.05)),
                index=held_in.keys.index(key),
            )
        )
    face, weight = markers_on(bundle, sheet, points)
    stencils, stars = sheet.stencils, [part.astype(np.int64) for part in sheet.stars]
    held = np.concatenate([grip.vertices for grip in grips]) if grips else np.zeros(0, int)
    owner = np.concatenate([np.full(len(grip.vertices), k) for k, grip in enumerate(grips)]) if grips else held
    pair, (ring_pair, stencil_pair, face_pair) = pairs_of(sheet)
    net = Net(
        faces=sheet.faces.astype(np.int64),
        first=stencils.first.astype(np.int64),
        node=stencils.node.astype(np.int64),
        centre=stencils.centre.astype(np.int64),
        second=np.ascontiguousarray(stencils.second),
        slope=np.ascontiguousarray(stencils.slope),
        ripple=np.ascontiguousarray(stencils.ripple),
        star_first=stars[0],
        star_face=stars[1],
        star_local=np.ascontiguousarray(stars[2]),
        ring_first=stars[3],
        ring_node=stars[4],
        pair=pair,
        ring_pair=ring_pair,
        stencil_pair=stencil_pair,
        face_pair=face_pair,
        held=held.astype(np.int64),
        grip=owner.astype(np.int64),
        marker_node=sheet.faces[face].astype(np.int64),
        marker_weight=np.ascontiguousarray(weight),
    )
    shape, velocity = start_of(bundle, recording, points, sheet)
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
        place=place,
        between=parents[-1],
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
