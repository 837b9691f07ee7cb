"""The recording that no fit and no choice sees, and how far a model is off on it."""

import numpy as np

from sim1.cloth.precise.held_places import held_places
from sim1.recording.bundle import Bundle


def held_out(bundle: Bundle, but: str | None = None) -> str:
    """The one whose motion, by the drives alone, is most like another's: what is asked is foretelling, not a new experiment.

    Where nobody measured how the cloth sits in its grips, one whose grips other recordings have too, if there is one: from these it
    is learnt, and what is left of it at rest would hold whatever else the resting markers are off by. A recording in which nothing
    holds the cloth tests what a fall tells, and no drive: it is held out only where there are not two others. `but` is not chosen.
    """
    features = {}
    for recording in (one for one in bundle.recordings if one.holds):
        rows = []
        for hold in recording.holds:
            track = recording.drives[hold.drive]
            time = np.linspace(track.time_s[0], track.time_s[-1], 200)
            place = np.stack([np.interp(time, track.time_s, track.position_m[:, k]) for k in range(3)], axis=1)
            speed = np.gradient(place, time, axis=0)
            rows.append(np.concatenate([np.std(place, axis=0), 0.2 * np.std(speed, axis=0), [0.2 * place[:, 2].min()]]))
        features[recording.name] = np.mean(rows, axis=0)
    names = list(features)
    if len(names) < 2:
        return [one.name for one in bundle.recordings if not one.holds and one.name != but][-1]
    nearest = {a: min(float(np.linalg.norm(features[a] - features[b])) for b in names if b != a) for a in names}
    names = [name for name in names if name != but]
    learnt = [name for name in names if _grips_are_learnt(bundle, name)]
    return min(reversed(learnt or names), key=lambda name: nearest[name])


def _grips_are_learnt(bundle: Bundle, name: str) -> bool:
    """Whether how the cloth sits in a recording's grips was measured, or shows in others."""
    held = held_places(bundle)
    keys = {r.name: {held.key(r, hold) for hold in r.holds} for r in bundle.recordings}
    others = set().union(*(keys[other] for other in keys if other != name))
    return keys[name] <= others | held.measured


def rmse_of(bundle: Bundle, markers: dict[str, np.ndarray], names: tuple[str, ...]) -> float:
    """Root mean square difference per coordinate, m, over recordings that all have markers (N, M, 3)."""
    parts = [(markers[r.name] - r.markers_m)[r.seen].ravel() for r in bundle.recordings if r.name in names]
    return float(np.sqrt(np.square(np.concatenate(parts)).mean()))
