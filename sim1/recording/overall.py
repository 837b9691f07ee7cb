"""The figures of a bundle that the rules ask for, by name: what all its recordings together offer."""

import numpy as np

from sim1.recording.bundle import Bundle
from sim1.recording.creep import creep_m
from sim1.recording.figures import RecordingFigures
from sim1.recording.lateness import LATE_S
from sim1.recording.marker_noise import MarkerNoise
from sim1.recording.sheet_fit import material_of_markers

SHRUNK = 0.015  # of a length: a usual shrinkage

type Overall = dict[str, float | None]
"""None: cannot be measured here."""


def overall(bundle: Bundle, figures: list[RecordingFigures]) -> Overall:
    """Figures over all recordings of a bundle."""
    normal = [f.normal_m_s[1] for f in figures if f.normal_m_s]
    tangential = [f.tangential_m_s[1] for f in figures if f.tangential_m_s]
    windows = [f.normal_windows_m_s for f in figures if f.normal_windows_m_s]
    slowest, fastest = min((w[0] for w in windows), default=None), max((w[1] for w in windows), default=None)
    noise = [f.noise for f in figures if f.noise and f.noise.at_rest] or [f.noise for f in figures if f.noise]
    correlation = [n.correlation_s for n in noise if n.correlation_s is not None]
    spread = bundle.prior.area_density_kg_m2.log_spread
    travels = np.concatenate([np.diff(t.position_m, axis=0) for r in bundle.recordings for t in r.drives.values()])
    creep = creep_m(bundle)
    strains = [f.strain / f.strain_noise for f in figures if f.strain_noise and f.strain is not None]
    paces = [f.speed_m_s[1] for f in figures]
    flat, length_noise = _flat(figures), _length_noise(bundle, noise)
    late = [f.late_s for f in figures if f.late_s is not None]
    return {
        "recordings": float(len(figures)),
        "markers": float(len(bundle.anchors.marker)),
        "marker_rate_hz": min(f.marker_rate_hz for f in figures),
        "seen_share": min(f.seen_share for f in figures),
        "longest_occlusion_s": max(f.longest_occlusion_s for f in figures),
        "rest_s": min(f.rest_s for f in figures),
        "rested": float(sum(f.rest_s >= 0.4 for f in figures)),
        "rest_at_end_s": max(f.rest_at_end_s for f in figures),
        "noise_m": bundle.noise_std_m or (float(np.median([n.std_m for n in noise])) if noise else None),
        "core_noise_m": float(np.median([n.core_std_m for n in noise])) if noise else None,
        "correlation_s": float(np.median(correlation)) if correlation else None,
        "correlation_frames": _product(np.median(correlation) if correlation else None, figures[0].marker_rate_hz),
        "density_known": None if spread is None else 1 / spread,
        "normal_m_s": max(normal, default=None),
        "tangential_m_s": max(tangential, default=None),
        "tangential_share": _ratio(max(tangential, default=None), max(normal, default=None)),
        "slowest_m_s": slowest,
        "fastest_m_s": fastest,
        "speed_ratio": _ratio(fastest, slowest),
        "pace_ratio": _ratio(max(paces), min(paces)),
        "facing_rad": _spread_rad([f.faces for f in figures if f.faces is not None]),
        "drive_turn_rad": max(f.drive_turn_rad for f in figures),
        "second_travel_share": _second_direction(travels),
        "has_table": 0.0 if bundle.environment.table is None else 1.0,
        "touches_s": max((f.touches_table_s or 0.0) for f in figures),
        "slide_m_s": max(max(f.slides_m_s) for f in figures),
        "slide_least_m_s": min(max(f.slides_m_s[k] for f in figures) for k in (0, 1)),
        "lifts": float(sum(f.lifts for f in figures)),
        "free_decay_s": max(f.free_decay_s for f in figures),
        "late_told": float(len(late)),
        "late_s": float(np.median(late)) if late else None,
        "late_from_s": min(late, default=None),
        "late_to_s": max(late, default=None),
        "punctual": float(abs(np.median(late)) < LATE_S) if late else None,
        "holds": float(sum(f.hold_count for f in figures)),
        "unmeasured_holds": float(sum(f.hold_count - f.measured_holds for f in figures)),
        "changed_holds": float(sum(f.changed_holds for f in figures)),
        "grips": float(len({tuple(sorted(h.vertices.tolist())) for r in bundle.recordings for h in r.holds})),
        "held_closed": 1.0 - max(float(f.open_while_held) for f in figures),
        "curvature_u_over_noise": _over(figures, 0),
        "curvature_v_over_noise": _over(figures, 1),
        "curvature_least_over_noise": _least(_over(figures, 0), _over(figures, 1)),
        "strain_over_noise": max(strains, default=None),
        "strain_percent": _product(max((f.strain for f in figures if f.strain is not None), default=None), 100),
        "flat": flat,
        "length_noise_percent": _product(length_noise, 100),
        "shrinkage_over_noise": _ratio(flat and SHRUNK, length_noise),
        "steady_markers": None if creep is None else float(creep == 0.0),
        "creep_mm": _product(creep, 1e3),
        "folded": float(sum(f.folded for f in figures)),
    }


def _flat(figures: list[RecordingFigures]) -> float | None:
    """Recordings in which the cloth is flat for long enough to see lengths along it."""
    fitted = [f for f in figures if f.curvature_1_m is not None]
    return float(sum(f.strain is not None for f in fitted)) if fitted else None


def _length_noise(bundle: Bundle, noise: list[MarkerNoise]) -> float | None:
    """What noise does to a length across all markers, along warp or weft where they span less: a share of it."""
    points = material_of_markers(bundle)
    span = 0.0 if points is None else float(np.ptp(points, axis=0).min())
    return float(np.sqrt(2) * np.median([n.core_std_m for n in noise])) / span if noise and span > 0 else None


def _ratio(a: float | None, b: float | None) -> float | None:
    return None if a is None or b is None else a / max(b, 1e-9)


def _product(a: float | None, b: float) -> float | None:
    return None if a is None else float(a) * b


def _least(a: float | None, b: float | None) -> float | None:
    return None if a is None or b is None else min(a, b)


def _over(figures: list[RecordingFigures], axis: int) -> float | None:
    both = [(f.curvature_1_m, f.curvature_noise_1_m) for f in figures if f.curvature_1_m and f.curvature_noise_1_m]
    return max((found[axis] / noise for found, noise in both), default=None)


def _spread_rad(faces: list[np.ndarray]) -> float | None:
    """Largest angle between the cloth's mean normal and its mean over all recordings."""
    found = np.concatenate(faces) if faces else np.empty((0, 3))
    if len(found) == 0:
        return None
    mean = found.mean(0)
    cosine = found @ mean / max(float(np.linalg.norm(mean)), 1e-9)
    return float(np.percentile(np.arccos(np.clip(cosine, -1, 1)), 95))


def _second_direction(steps_m: np.ndarray) -> float:
    """How much of the drives' motion is across their main direction, 0 to 1."""
    size = np.linalg.svd(steps_m, compute_uv=False)
    return float(size[1] / size[0]) if size[0] > 1e-9 else 0.0
