"""A stand-in for a motion-capture lab: a virtual swatch, hung by an edge between the jaws of two clamps, swung and filmed. Nothing here is real cloth.

It shares the sheet model with the estimator (a difference of solvers is not what it tests) but runs on a mesh 2.5 times as fine with
a quarter of its time step, with parameters drawn around the priors and, for some garments, with still air that the baseline lacks.
"""

from dataclasses import asdict, dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from sim1.mismatch.dynamics import HeldSheet
from sim1.mismatch.replay import drive_path, hang
from sim1.mismatch.sheet import Material, Sheet, Swatch, place_on
from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.document import Environment, Priors
from sim1.recording.mesh import RestMesh
from sim1.recording.streams import Anchors, Track

COMMAND_HZ = 100.0
REST_S = 0.5
HEIGHT_M = 0.8
# Amplitude and frequency of the motion across the sheet [m, Hz], of the turn about the vertical [rad, Hz] and of the lift [m, Hz].
# Gentle, and from a flat start, on purpose: in larger swings, or hung along an arc, the sheet buckles and snaps, and markers then
# depend on its parameters chaotically: neither this version's fit nor any other tells a modulus from such a motion.
SWINGS = {
    "slow": ((0.04, 0.9), (0.0, 1.0), (0.01, 1.4)),
    "fast": ((0.02, 1.7), (0.03, 1.1), (0.0, 1.0)),
    "mixed": ((0.03, 1.3), (0.05, 0.8), (0.01, 1.1)),
}
GRAVITY = (0.0, 0.0, -9.81)
AIR_DENSITY_KG_M3 = 1.2


@dataclass(frozen=True, kw_only=True)
class Setup:
    """Sizes of the stand-in lab."""

    side_m: float
    vertices_per_side: int
    lab_vertices_per_side: int
    lab_step_s: float
    duration_s: float
    markers_per_side: int
    marker_rate_hz: float
    noise_std_m: float
    outlier_share: float
    dropout_share: float
    swings: tuple[str, ...]


def draw_material(priors: Priors, air_probability: float, stream: np.random.Generator) -> Material:
    """The concealed truth: each parameter from its prior, at most 1.5 standard deviations off; air with the given probability."""
    values = {}
    for name in ("area_density_kg_m2", "stretch_n_m", "poisson", "bending_n_m", "damping_s"):
        prior = getattr(priors, name)
        off = np.clip(stream.standard_normal(), -1.5, 1.5)
        values[name] = (
            prior.value * np.exp(off * prior.log_std) if prior.log_std else prior.value + off * (prior.std or 0.0)
        )
    air = stream.random() < air_probability
    c_normal = float(stream.uniform(1.1, 2.0))
    values["poisson"] = min(max(values["poisson"], 0.05), 0.45)
    return Material(**{key: float(value) for key, value in values.items()}, c_normal=c_normal if air else 0.0)


def record(priors: Priors, material: Material, setup: Setup, stream: np.random.Generator, progress=iter) -> Bundle:
    """Film the swings of a virtual swatch of this material; `progress` wraps the list of swings."""
    coarse = Swatch(side_m=setup.side_m, vertices_per_side=setup.vertices_per_side).sheet()
    fine = Swatch(side_m=setup.side_m, vertices_per_side=setup.lab_vertices_per_side).sheet()
    spots = _spots(setup, stream)
    face, weight = place_on(coarse, spots)
    anchors = Anchors(marker=np.arange(len(spots)), face=face, weight=weight)
    spacing = setup.side_m / (setup.vertices_per_side - 1)
    jaw_m = (setup.vertices_per_side // 2 - 1) * spacing  # half of the edge less the gap in the middle
    recordings = tuple(
        _film(name, coarse, fine, jaw_m, spots, material, setup, stream) for name in progress(setup.swings)
    )
    vertices = np.column_stack([coarse.material_m, np.zeros(len(coarse.material_m))])
    return Bundle(
        mesh=RestMesh(vertices_m=vertices, faces=coarse.faces, material_m=coarse.material_m),
        prior=priors,
        environment=Environment(gravity_m_s2=GRAVITY, air_density_kg_m3=AIR_DENSITY_KG_M3, table=None),
        noise_std_m=None,
        anchors=anchors,
        recordings=recordings,
    )


def _spots(setup: Setup, stream: np.random.Generator) -> np.ndarray:
    """Material coordinates (M, 2) of markers stuck on by hand: a grid, each a few millimetres off it."""
    n = setup.markers_per_side
    axis = (np.arange(n) + 0.5) / n * setup.side_m
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    return grid + stream.uniform(-0.1, 0.1, grid.shape) * setup.side_m / n


def _commands(name: str, setup: Setup, jaw_m: float) -> dict[str, Track]:
    """Two clamps that rest, swing and stop; one of `SWINGS`."""
    time = np.arange(round(setup.duration_s * COMMAND_HZ) + 1) / COMMAND_HZ
    run = np.clip((time - REST_S) / (setup.duration_s - REST_S - 0.2), 0, 1)
    envelope = np.sin(np.pi * run) ** 2
    across, yaw, lift = (size * envelope * np.sin(2 * np.pi * hertz * (time - REST_S)) for size, hertz in SWINGS[name])
    middle = np.column_stack([0 * time, across, HEIGHT_M + lift])
    tracks = {}
    for drive, sign in (("left", -1.0), ("right", 1.0)):
        offset = np.array([sign * (setup.side_m - jaw_m) / 2, 0.0, 0.0])
        turn = Rotation.from_euler("z", yaw[:, None])
        tracks[drive] = Track(
            time_s=time,
            position_m=middle + turn.apply(offset),
            rotation_wxyz=turn.as_quat(scalar_first=True),
            openness=np.zeros(len(time)),
        )
    return tracks


def _clamped(sheet: Sheet, side_m: float, jaw_m: float) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Vertices in each clamp and their places in its frame, x along the edge."""
    u, v = sheet.material_m.T
    found = {}
    for drive, near in (("left", u <= jaw_m + 1e-9), ("right", u >= side_m - jaw_m - 1e-9)):
        vertices = np.flatnonzero((v < 1e-9) & near)
        middle = jaw_m / 2 if drive == "left" else side_m - jaw_m / 2
        found[drive] = vertices, np.column_stack([u[vertices] - middle, np.zeros((len(vertices), 2))])
    return found


def _film(
    name: str,
    coarse: Sheet,
    fine: Sheet,
    jaw_m: float,
    spots: np.ndarray,
    material: Material,
    setup: Setup,
    stream: np.random.Generator,
) -> Recording:
    drives = _commands(name, setup, jaw_m)
    time = np.arange(round(setup.duration_s / setup.lab_step_s) + 1) * setup.lab_step_s
    clamps = _clamped(fine, setup.side_m, jaw_m)
    held = np.concatenate([vertices for vertices, _ in clamps.values()])
    path = np.concatenate([drive_path(drives[drive], places, time) for drive, (_, places) in clamps.items()], axis=1)
    gravity = np.array(GRAVITY)
    body = HeldSheet(fine, held)
    rest = body.rest(material, hang(fine, held, path[0], gravity), gravity)
    shapes = body.motion(material, rest, path, setup.lab_step_s, gravity)
    face, weight = place_on(fine, spots)
    marked = (shapes[:, fine.faces[face]] * weight[..., None]).sum(2)
    frames = np.arange(int(setup.duration_s * setup.marker_rate_hz) + 1) / setup.marker_rate_hz
    holds = tuple(
        Hold(drive=drive, vertices=vertices, from_s=0.0, to_s=float(drives[drive].time_s[-1]), places_m=places)
        for drive, (vertices, places) in _clamped(coarse, setup.side_m, jaw_m).items()
    )
    markers = _filmed(CubicSpline(time, marked)(np.minimum(frames, time[-1])), setup, stream)
    return Recording(name=f"swing_{name}", starts="rest", holds=holds, time_s=frames, markers_m=markers, drives=drives)


def _filmed(markers: np.ndarray, setup: Setup, stream: np.random.Generator) -> np.ndarray:
    """Markers as the cameras see them: Gaussian noise, a few gross errors, drop-outs of several frames."""
    seen = markers + setup.noise_std_m * stream.standard_normal(markers.shape)
    gross = stream.random(markers.shape[:2]) < setup.outlier_share
    seen += gross[..., None] * 6 * setup.noise_std_m * stream.standard_normal(markers.shape)
    run = 6  # frames that a drop-out lasts
    starts = stream.random(markers.shape[:2]) < setup.dropout_share / run
    hidden = np.lib.stride_tricks.sliding_window_view(np.pad(starts, ((run - 1, 0), (0, 0))), run, axis=0).any(-1)
    seen[hidden] = np.nan
    return seen


def truth(material: Material) -> dict[str, float]:
    """The concealed parameters, for sealing and for tests that open the seal."""
    return {key: float(f"{value:.9g}") for key, value in asdict(material).items()}
