"""Where the cloth sits in its grips, estimated where nobody measured it."""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.cloth.precise.drives import drive_pose
from sim1.cloth.precise.material import marker_points, sheet_of
from sim1.cloth.precise.start import resting_shape
from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.motion import rest_until_s
from sim1.stage import BadInput

REGRIPPED_M = (
    0.015  # by which a recording's place must differ from the mean of all before the cloth was taken up anew for it
)

type Key = tuple[str, tuple[int, ...], str]  # drive, vertices, recording if its places are its own, else empty


@dataclass(frozen=True, kw_only=True)
class HeldPlaces:
    """Where the cloth sits in each grip of a bundle."""

    places_m: dict[Key, np.ndarray]  # (h, 3) in the drive's frame
    measured: frozenset[Key]  # by the lab; the others were estimated

    @property
    def keys(self) -> list[Key]:
        """In the order of a world's `places`."""
        return sorted(self.places_m)

    def key(self, recording: str, hold: Hold) -> Key:
        """Which of them a hold has: its recording's own, or that which recordings share."""
        own = (*_short(hold), recording)
        return own if own in self.places_m else (*_short(hold), "")


def held_places(bundle: Bundle) -> HeldPlaces:
    """Places of each grip's vertices: as measured, else the flat patch fitted to the resting markers.

    Recordings share what nobody measured, unless their resting markers show that the cloth was taken up anew.

    Raises:
        BadInput: places that nobody measured, and no recording starts at rest in that grip with enough markers to be seen.
    """
    holds = [(recording, hold) for recording in bundle.recordings for hold in recording.holds]
    measured = _measured(holds)
    found = dict(measured)
    estimates = _estimates(bundle, [one for one in holds if not _known(measured, *one)])
    for short, parts in estimates.items():
        mean = np.mean(list(parts.values()), axis=0)
        found[(*short, "")] = mean
        if max(np.linalg.norm((part - mean).mean(0)) for part in parts.values()) > REGRIPPED_M:
            found |= {(*short, recording): part for recording, part in parts.items()}
            if all(recording.name in parts for recording, hold in holds if _short(hold) == short):
                del found[(*short, "")]
    for recording, hold in holds:
        if _short(hold) not in estimates and not _known(measured, recording, hold):
            raise BadInput(
                f"{bundle.folder / 'bundle.yaml'}: recording {recording.name}: places_m of drive {hold.drive!r} is null and no recording starts at rest "
                "in this grip; measure where the cloth sits in it"
            )
    return HeldPlaces(places_m=found, measured=frozenset(measured))


def _short(hold: Hold) -> tuple[str, tuple[int, ...]]:
    return hold.drive, tuple(int(v) for v in hold.vertices)


def _measured(holds: list[tuple[Recording, Hold]]) -> dict[Key, np.ndarray]:
    """Places that the lab knows: one for all recordings, or each its own where they differ."""
    given: dict[tuple[str, tuple[int, ...]], dict[str, np.ndarray]] = {}
    for recording, hold in holds:
        if hold.places_m is not None:
            given.setdefault(_short(hold), {})[recording.name] = hold.places_m
    found: dict[Key, np.ndarray] = {}
    for short, parts in given.items():
        first = next(iter(parts.values()))
        if all(np.array_equal(part, first) for part in parts.values()):
            found[(*short, "")] = first
        else:
            found |= {(*short, recording): part for recording, part in parts.items()}
    return found


def _known(measured: dict[Key, np.ndarray], recording: Recording, hold: Hold) -> bool:
    return (*_short(hold), "") in measured or (*_short(hold), recording.name) in measured


def _estimates(
    bundle: Bundle, holds: list[tuple[Recording, Hold]]
) -> dict[tuple[str, tuple[int, ...]], dict[str, np.ndarray]]:
    """By grip and recording, places (h, 3) m."""
    sheet, points = sheet_of(bundle), marker_points(bundle)
    found: dict[tuple[str, tuple[int, ...]], dict[str, np.ndarray]] = {}
    for recording, hold in holds:
        if recording.starts != "rest":
            continue
        if hold.from_s > rest_until_s(recording) + 0.05:  # taken up later: the resting markers do not show it
            continue
        seen = resting_shape(bundle, recording, points, sheet)[hold.vertices]
        position, turn = drive_pose(recording.drives[hold.drive], np.array([recording.time_s[0]]))
        local = (seen - position[0]) @ turn[0]
        flat = np.column_stack([sheet.material_m[hold.vertices], np.zeros(len(hold.vertices))])
        if len(flat) > 1:
            with warnings.catch_warnings():  # vertices on one line leave the turn about it open: any will do
                warnings.simplefilter("ignore", UserWarning)
                rotation, _ = Rotation.align_vectors(local - local.mean(0), flat - flat.mean(0))
            local = rotation.apply(flat - flat.mean(0)) + local.mean(0)
        found.setdefault(_short(hold), {})[recording.name] = local
    return found
