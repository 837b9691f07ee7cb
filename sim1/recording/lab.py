"""A stand-in for a motion-capture lab: a virtual swatch, hung by an edge between the jaws of two clamps, swung and filmed. Nothing here is real cloth.

It films with the simulator that the diagnosis calibrates: formulas of the sheet, of its clamps and of still air, and the way of
stepping through time are the same on both sides, so nothing that these get wrong can show. What differs: mesh, time step, the
parameters, which are drawn around the priors and concealed, and effects that the baseline lacks (`sim1.recording.concealed`).
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.cloth.precise.mesh import Sheet, place_on, square_sheet
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import simulate
from sim1.cloth.precise.world import World
from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.document import Environment, Priors
from sim1.recording.mesh import RestMesh
from sim1.recording.motion import REST_S
from sim1.recording.streams import Anchors, Track

COMMAND_HZ = 100.0
HEIGHT_M = 0.8
# Amplitude and frequency of the motion across the sheet [m, Hz], of the turn about the vertical [rad, Hz] and of the lift [m, Hz].
# Gentle, and from a flat start, on purpose: in larger swings, or hung along an arc, the sheet buckles and snaps, and markers then
# depend on its parameters chaotically: little can be told from such a motion.
SWINGS = {
    "slow": ((0.04, 0.9), (0.0, 1.0), (0.01, 1.4)),
    "fast": ((0.02, 1.7), (0.03, 1.1), (0.0, 1.0)),
    "mixed": ((0.03, 1.3), (0.05, 0.8), (0.01, 1.1)),
}
GRAVITY = (0.0, 0.0, -9.81)
AIR_DENSITY_KG_M3 = 1.2
FABRIC = ("area_density_kg_m2", "stretch_n_m", "poisson", "bending_n_m", "damping_s")


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


def draw_fabric(priors: Priors, stream: np.random.Generator) -> World:
    """The concealed fabric without any effect: each parameter from its prior, at most 1.5 standard deviations off."""
    values = {}
    for name in FABRIC:
        prior = getattr(priors, name)
        off = float(np.clip(stream.standard_normal(), -1.5, 1.5))
        values[name] = (
            prior.value * np.exp(off * prior.log_std) if prior.log_std else prior.value + off * (prior.std or 0.0)
        )
    values["poisson"] = min(max(values["poisson"], 0.05), 0.45)
    return World(
        **{name: float(value) for name, value in values.items()},
        gravity_m_s2=GRAVITY,
        air_density_kg_m3=AIR_DENSITY_KG_M3,
    )


def record(priors: Priors, world: World, setup: Setup, stream: np.random.Generator, progress=iter) -> Bundle:
    """Film the swings of a virtual swatch of this world; `progress` wraps the list of swings.

    Raises:
        NotConverged: a swing that the sheet cannot follow.
    """
    spots = _spots(setup, stream)
    own = _unfilmed(priors, setup, setup.lab_vertices_per_side, spots)
    markers = {}
    for recording in progress(own.recordings):
        run = simulate(prepare(own, recording, setup.lab_step_s), [world])
        markers[recording.name] = _filmed(run.markers_m[0], setup, stream)
    given = _unfilmed(priors, setup, setup.vertices_per_side, spots)
    recordings = tuple(replace(one, markers_m=markers[one.name]) for one in given.recordings)
    return replace(given, recordings=recordings)


def _unfilmed(priors: Priors, setup: Setup, count: int, spots: np.ndarray) -> Bundle:
    """The bundle on a mesh of count x count vertices; markers (M, 3) stay where a flat hanging sheet has them."""
    sheet = square_sheet(count, setup.side_m)
    face, weight = place_on(sheet, spots)
    spacing = setup.side_m / (setup.vertices_per_side - 1)
    jaw_m = (setup.vertices_per_side // 2 - 1) * spacing  # half of the edge less the gap in the middle
    clamps = _clamped(sheet, setup.side_m, jaw_m)
    frames = np.arange(int(setup.duration_s * setup.marker_rate_hz) + 1) / setup.marker_rate_hz
    hanging = np.column_stack([spots[:, 0] - setup.side_m / 2, 0 * spots[:, 0], HEIGHT_M - spots[:, 1]])
    recordings = []
    for name in setup.swings:
        drives = _commands(name, setup, jaw_m)
        holds = tuple(
            Hold(drive=drive, vertices=vertices, from_s=0.0, to_s=float(drives[drive].time_s[-1]), places_m=places)
            for drive, (vertices, places) in clamps.items()
        )
        markers = np.repeat(hanging[None], len(frames), axis=0)
        recordings.append(
            Recording(name=f"swing_{name}", starts="rest", holds=holds, time_s=frames, markers_m=markers, drives=drives)
        )
    vertices = np.column_stack([sheet.material_m, np.zeros(len(sheet.material_m))])
    return Bundle(
        mesh=RestMesh(vertices_m=vertices, faces=sheet.faces, material_m=sheet.material_m),
        prior=priors,
        environment=Environment(gravity_m_s2=GRAVITY, air_density_kg_m3=AIR_DENSITY_KG_M3, table=None),
        noise_std_m=None,
        anchors=Anchors(marker=np.arange(len(spots)), face=face, weight=weight),
        recordings=tuple(recordings),
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


def truth(world: World) -> dict[str, Any]:
    """Every concealed number that is not what a world has by default, to nine digits: for sealing and for tests that open the seal."""
    usual = {field.name: field.default for field in fields(World)}
    return {
        name: _nine(value) for name in usual if (value := getattr(world, name)) is not None and value != usual[name]
    }


def _nine(value: Any) -> Any:
    return [_nine(one) for one in value] if isinstance(value, tuple) else float(f"{value:.9g}")
