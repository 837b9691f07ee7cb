"""Where, when and in what way recordings and simulation differ."""

from dataclasses import dataclass

import numpy as np

from sim1.recording.bundle import Recording

WINDOW_S = 0.2
WINDOWS_SHOWN = 3
REGION_SHARE = 0.5  # the fewest markers that carry this share of the unexplained motion form the region


@dataclass(frozen=True, kw_only=True)
class Window:
    """A stretch of time in a recording and its share of the unexplained motion."""

    recording: str
    from_s: float
    to_s: float
    share: float


@dataclass(frozen=True, kw_only=True)
class Location:
    """Unexplained motion by place and by time: mean square above the floor, m^2."""

    marker_excess_m2: np.ndarray  # (M,)
    windows: tuple[Window, ...]  # every window, in order of time
    along_motion: (
        float  # share of the residual that lies along the simulated velocity; 1/3 where direction plays no part
    )
    fast_over_slow: float  # rms of the residual where markers are faster than the median, over where they are slower

    def region(self) -> tuple[list[int], float]:
        """Columns of the markers that carry most, and their share; empty where nothing exceeds the floor."""
        total = self.marker_excess_m2.sum()
        if total <= 0:
            return [], 0.0
        order = np.argsort(-self.marker_excess_m2, kind="stable")
        share = np.cumsum(self.marker_excess_m2[order]) / total
        count = int(np.argmax(share >= REGION_SHARE)) + 1
        return sorted(int(k) for k in order[:count]), float(share[count - 1])

    def worst_windows(self) -> list[Window]:
        """The windows with the largest shares, largest first."""
        return sorted((w for w in self.windows if w.share > 0), key=lambda w: -w.share)[:WINDOWS_SHOWN]


def locate(recordings: tuple[Recording, ...], simulated_m: dict[str, np.ndarray], floor_m: float) -> Location:
    """Map the residual of simulated markers (T, M, 3) above a floor per coordinate, in m."""
    squares, counts, windows, along, whole, fast, slow = 0.0, 0.0, [], 0.0, 0.0, [], []
    for recording in recordings:
        off = recording.markers_m - simulated_m[recording.name]
        seen = recording.seen
        power = np.where(seen, np.square(off).mean(-1), 0.0)
        squares, counts = squares + power.sum(0), counts + seen.sum(0)
        for start in np.arange(recording.time_s[0], recording.time_s[-1], WINDOW_S):
            rows = (recording.time_s >= start) & (recording.time_s < start + WINDOW_S)
            excess = max(float(power[rows].sum() - floor_m**2 * seen[rows].sum()), 0.0)
            windows.append((recording.name, float(start), float(min(start + WINDOW_S, recording.time_s[-1])), excess))
        velocity = np.gradient(simulated_m[recording.name], recording.time_s, axis=0)
        speed = np.linalg.norm(velocity, axis=-1)
        moving = seen & (speed > 0.02)
        unit = velocity[moving] / speed[moving][:, None]
        along += float(np.square((off[moving] * unit).sum(-1)).sum())
        whole += float(np.square(off[moving]).sum())
        middle = np.median(speed[moving]) if moving.any() else 0.0
        fast.append(power[moving & (speed >= middle)])
        slow.append(power[moving & (speed < middle)])
    total = sum(window[3] for window in windows)
    return Location(
        marker_excess_m2=np.maximum(squares / np.maximum(counts, 1) - floor_m**2, 0.0),
        windows=tuple(
            Window(recording=n, from_s=a, to_s=b, share=e / total if total else 0.0) for n, a, b, e in windows
        ),
        along_motion=along / whole if whole else 0.0,
        fast_over_slow=_root_mean(fast) / max(_root_mean(slow), 1e-12),
    )


def _root_mean(parts: list[np.ndarray]) -> float:
    values = np.concatenate(parts)
    return float(values.mean() ** 0.5) if len(values) else 0.0


def signature(location: Location, floor_m: float, rmse_m: float) -> str:
    """One plain sentence about the unexplained motion."""
    return (
        f"Markers stray by {1e3 * rmse_m:.2f} mm rms where noise and mesh explain {1e3 * floor_m:.2f} mm; "
        f"{100 * location.along_motion:.0f} % of it lies along the direction of motion (33 % if direction played no part), "
        f"and it is {location.fast_over_slow:.1f} times as large on fast markers as on slow ones."
    )
