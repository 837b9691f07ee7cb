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

type Short = tuple[str, tuple[int, ...]]  # drive, vertices
# With the recording if its places are its own, else empty; and which of its holds of this grip it is.
type Key = tuple[str, tuple[int, ...], str, int]


@dataclass(frozen=True, kw_only=True)
class HeldPlaces:
    """Where the cloth sits in each grip of a bundle."""

    places_m: dict[Key, np.ndarray]  # (h, 3) in the drive's frame
    measured: frozenset[Key]  # by the lab; the others were estimated

    @property
    def keys(self) -> list[Key]:
        """In the order of a world's `places`."""
        return sorted(self.places_m)

    def key(self, recording: Recording, hold: Hold) -> Key:
        """Which of them a hold of a recording has: its own, or that which recordings share."""
        short = short_of(hold)
        own = (*short, recording.name, _number(recording, hold))
        return own if own in self.places_m else (*short, "", 0)


def held_places(bundle: Bundle) -> HeldPlaces:
    """Places of each grip's vertices: as measured, else the flat patch fitted to the resting markers.

    Recordings share what nobody measured, unless their resting markers show that the cloth was taken up anew. Where no recording rests
    in such a grip, but others measured it, it is taken to be about there, and calibrated.

    Raises:
        BadInput: places that nobody measured, and no recording starts at rest in that grip with enough markers to be seen.
    """
    holds = [(recording, hold, _number(recording, hold)) for recording in bundle.recordings for hold in recording.holds]
    measured = _measured(holds)
    unknown = [(recording, hold) for recording, hold, _ in holds if hold.places_m is None]
    found, estimates = dict(measured), resting_places(bundle)
    for short, parts in estimates.items():
        mean = np.mean(list(parts.values()), axis=0)
        found[(*short, "", 0)] = mean
        if max(np.linalg.norm((part - mean).mean(0)) for part in parts.values()) > REGRIPPED_M:
            found |= {(*short, recording, 0): part for recording, part in parts.items()}
            own = [number == 0 and recording.name in parts for recording, hold, number in holds if _is(hold, short)]
            if all(own):
                del found[(*short, "", 0)]
    for recording, hold in unknown:
        if short_of(hold) not in estimates:
            known = [places for key, places in measured.items() if key[:2] == short_of(hold)]
            if not known:
                raise BadInput(
                    f"{bundle.folder / 'bundle.yaml'}: recording {recording.name}: places_m of drive {hold.drive!r} is null and no recording starts at rest "
                    "in this grip; measure where the cloth sits in it"
                )
            found[(*short_of(hold), "", 0)] = np.mean(known, axis=0)
    return HeldPlaces(places_m=found, measured=frozenset(measured))


def short_of(hold: Hold) -> Short:
    """The grip that a hold is of, whatever recording."""
    return hold.drive, tuple(int(v) for v in hold.vertices)


def _number(recording: Recording, hold: Hold) -> int:
    """How often the recording has held this grip before."""
    return sum(short_of(one) == short_of(hold) for one in recording.holds if one.from_s < hold.from_s)


def _is(hold: Hold, short: Short) -> bool:
    return hold.places_m is None and short_of(hold) == short


def _measured(holds: list[tuple[Recording, Hold, int]]) -> dict[Key, np.ndarray]:
    """Places that the lab knows: one for all recordings, or each hold its own where they differ or some are not known."""
    given: dict[Short, dict[tuple[str, int], np.ndarray]] = {}
    for recording, hold, number in holds:
        if hold.places_m is not None:
            given.setdefault(short_of(hold), {})[recording.name, number] = hold.places_m
    found: dict[Key, np.ndarray] = {}
    for short, parts in given.items():
        first = next(iter(parts.values()))
        alike = all(np.array_equal(part, first) for part in parts.values())
        if alike and not any(_is(hold, short) for _, hold, _ in holds):
            found[(*short, "", 0)] = first
        else:
            found |= {(*short, *own): part for own, part in parts.items()}
    return found


def resting_places(bundle: Bundle) -> dict[Short, dict[str, np.ndarray]]:
    """What resting markers say of the grips that nobody measured: by grip and recording, places (h, 3) m in the drive's frame.

    Raises:
        BadInput: too few markers are seen at rest, or all on one line.
    """
    sheet, points = sheet_of(bundle), marker_points(bundle)
    found: dict[Short, dict[str, np.ndarray]] = {}
    for recording, hold in [(one, hold) for one in bundle.recordings for hold in one.holds]:
        if hold.places_m is not None or recording.starts != "rest":
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
        found.setdefault(short_of(hold), {})[recording.name] = local
    return found
