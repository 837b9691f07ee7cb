"""Simulate a recording: the sheet hangs from the drives' first poses until it rests, then follows their commands."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from sim1.mismatch.dynamics import HeldSheet
from sim1.mismatch.sheet import Material, Sheet, place_on, refined
from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.streams import Track
from sim1.stage import BadInput

STILL_M, STILL_RAD = 2e-4, 1e-3  # a drive that stays this close to its first pose rests


def sheet_of(bundle: Bundle) -> Sheet:
    """The bundle's rest mesh as a flat sheet.

    Raises:
        BadInput: the mesh has no material coordinates.
    """
    if bundle.mesh.material_m is None:
        raise BadInput(
            "garment.obj: no material coordinates; write them as `vt` in metres: calibration takes the rest shape as flat"
        )
    return Sheet(material_m=bundle.mesh.material_m, faces=bundle.mesh.faces)


def drive_path(track: Track, places_m: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Where points fixed in a drive's frame (h, 3) are at the given times: (T, h, 3). Constant outside the track."""
    time = np.clip(time_s, *track.time_s[[0, -1]])
    position = CubicSpline(track.time_s, track.position_m)(time)
    turn = Slerp(track.time_s, Rotation.from_quat(track.rotation_wxyz, scalar_first=True))(time).as_matrix()
    return position[:, None] + np.einsum("tij,hj->thi", turn, places_m)


def rest_until_s(recording: Recording) -> float:
    """Time at which the first drive begins to move."""
    ends = []
    for track in recording.drives.values():
        away = np.linalg.norm(track.position_m - track.position_m[0], axis=1) > STILL_M
        turned = 2 * np.arccos(np.clip(np.abs(track.rotation_wxyz @ track.rotation_wxyz[0]), 0, 1)) > STILL_RAD
        moves = away | turned
        ends.append(track.time_s[max(int(np.argmax(moves)) - 1, 0)] if moves.any() else track.time_s[-1])
    return float(min(ends))


@dataclass(frozen=True, kw_only=True)
class Replay:
    """A recording made ready to be simulated again and again with other materials."""

    held_sheet: HeldSheet
    held_path: np.ndarray  # (steps, held, 3) from the start of motion on
    time_s: np.ndarray  # (steps,)
    hanging: (
        np.ndarray
    )  # (V, 3) unstretched sheet, hung from its held vertices: where the search for equilibrium starts
    anchor_vertices: np.ndarray  # (M, 3)
    anchor_weights: np.ndarray  # (M, 3)
    frame_s: np.ndarray  # (T,) times of the markers' frames
    gravity: np.ndarray

    def shapes(self, material: Material, near: np.ndarray | None = None) -> np.ndarray:
        """Shapes (steps, V, 3); `near` is a shape close to the equilibrium, to start from."""
        start = self.hanging if near is None else near.copy()
        start[self.held_sheet.held] = self.held_path[0]
        rest = self.held_sheet.rest(material, start, self.gravity)
        return self.held_sheet.motion(
            material, rest, self.held_path, float(self.time_s[1] - self.time_s[0]), self.gravity
        )

    def markers(self, shapes: np.ndarray) -> np.ndarray:
        """Markers (T, M, 3) at the frames of the recording."""
        path = (shapes[:, self.anchor_vertices] * self.anchor_weights[..., None]).sum(2)
        return CubicSpline(self.time_s, path)(np.clip(self.frame_s, *self.time_s[[0, -1]]))


def prepare(bundle: Bundle, recording: Recording, step_s: float, finer: bool = False) -> Replay:
    """Make a recording ready: `finer` cuts every face into four.

    Raises:
        BadInput: the recording needs what this simulator has not: a table, a start in motion, a hold that is let go or
            taken up on the way, places of held vertices that nobody measured.
    """
    _check(bundle, recording)
    sheet = sheet_of(bundle)
    between = np.repeat(np.arange(len(sheet.material_m))[:, None], 2, axis=1)
    anchor = (sheet.material_m[sheet.faces[bundle.anchors.face]] * bundle.anchors.weight[..., None]).sum(1)
    if finer:
        sheet, between = refined(sheet)
    first, last = rest_until_s(recording), float(recording.time_s[-1])
    start = min(max(first, float(recording.time_s[0])), last - 3 * step_s)
    time = start + step_s * np.arange(int(np.ceil((last - start) / step_s)) + 1)
    held, path = [], []
    for hold in recording.holds:
        vertices, places = _held_points(hold, between)
        held.append(vertices)
        path.append(drive_path(recording.drives[hold.drive], places, time))
    held_all, path_all = np.concatenate(held), np.concatenate(path, axis=1)
    gravity = np.array(bundle.environment.gravity_m_s2)
    face, weight = place_on(sheet, anchor)
    return Replay(
        held_sheet=HeldSheet(sheet, held_all),
        held_path=path_all,
        time_s=time,
        hanging=hang(sheet, held_all, path_all[0], gravity),
        anchor_vertices=sheet.faces[face],
        anchor_weights=weight,
        frame_s=recording.time_s,
        gravity=gravity,
    )


def _held_points(hold: Hold, between: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices whose two parents are both in the hold, and their places in the drive's frame."""
    inside = np.isin(between, hold.vertices).all(1)
    place = {int(vertex): hold.places_m[k] for k, vertex in enumerate(hold.vertices)}
    vertices = np.flatnonzero(inside)
    return vertices, np.array([(place[int(a)] + place[int(b)]) / 2 for a, b in between[vertices]])


def hang(sheet: Sheet, held: np.ndarray, held_m: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """The flat sheet turned so that its held vertices fit their places best and the rest hangs down, (V, 3)."""
    flat = np.column_stack([sheet.material_m, np.zeros(len(sheet.material_m))])
    pivot, target = flat[held].mean(0), held_m.mean(0)
    down = flat.mean(0) - pivot
    lower = target + gravity / np.linalg.norm(gravity) * np.linalg.norm(down)
    source = np.vstack([flat[held] - pivot, down])
    turn, _ = Rotation.align_vectors(np.vstack([held_m - target, lower - target]), source)
    shape = turn.apply(flat - pivot) + target
    shape[held] = held_m
    return shape


def _check(bundle: Bundle, recording: Recording) -> None:
    place = f"bundle.yaml: recording {recording.name}"
    if not recording.holds:
        raise BadInput(f"{place}: nothing holds the cloth; this version calibrates with held sheets alone")
    if recording.starts != "rest":
        raise BadInput(f"{place}: starts is {recording.starts!r}; this version needs recordings that start at rest")
    if bundle.environment.table is not None:
        raise BadInput(
            "bundle.yaml: environment.table is given; this version calibrates sheets that hang free (table: null)"
        )
    for hold in recording.holds:
        if hold.places_m is None:
            raise BadInput(
                f"{place}: places_m of drive {hold.drive!r} is null; measure where the cloth sits in the gripper's frame"
            )
        track = recording.drives[hold.drive]
        if hold.from_s > track.time_s[0] + 0.1 or hold.to_s < recording.time_s[-1] - 0.1:
            raise BadInput(
                f"{place}: drive {hold.drive!r} holds from {hold.from_s} to {hold.to_s} s; this version needs holds that last throughout"
            )
