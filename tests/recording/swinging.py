"""A cloth whose motion is known in closed form: a stiff board on a bar, so that every figure has a right answer."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.document import Environment, Friction, Prior, Priors, Table
from sim1.recording.mesh import RestMesh
from sim1.recording.streams import Anchors, Track

SIDE, ROW, BAR_M = 0.3, 6, 0.8  # a square of 6 x 6 vertices, its upper edge on a bar at 0.8 m
PRIORS = {
    "area_density_kg_m2": Prior(value=0.2, std=0.01),
    "thickness_m": Prior(value=0.001),
    "stretch_n_m": Prior(value=400.0, log_std=0.7),
    "poisson": Prior(value=0.3, std=0.1),
    "bending_n_m": Prior(value=2e-5, log_std=0.7),
    "damping_s": Prior(value=1e-3, log_std=1.0),
}


def board() -> RestMesh:
    axis = np.linspace(0, SIDE, ROW)
    flat = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    corner = np.array([j * ROW + i for j in range(ROW - 1) for i in range(ROW - 1)])
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + ROW + 1], 1), np.stack([corner, corner + ROW + 1, corner + ROW], 1)]
    )
    return RestMesh(vertices_m=np.column_stack([flat, np.zeros(len(flat))]), faces=faces, material_m=flat)


def swing(
    name: str,
    *,
    peak_rad_s: float = 3.0,
    hertz: float = 1.0,
    rest_s: float = 1.0,
    moves_s: float = 2.0,
    noise_m: float = 0.0,
    correlation_s: float = 0.0,
    rate_hz: float = 100.0,
    shift_m: float = 0.2,
    drop_m: float = 0.0,
    turn_rad: float = 0.0,
    seed: int = 0,
) -> Recording:
    """The bar moves by `shift_m` across the board (and down by `drop_m`), stops dead; the board swings on about it."""
    time = np.arange(round((rest_s + moves_s + 1.5) * rate_hz)) / rate_hz
    run = np.clip((time - rest_s) / moves_s, 0, 1)
    angle = peak_rad_s / (2 * np.pi * hertz) * np.sin(2 * np.pi * hertz * np.clip(time - rest_s, 0, None))
    bar = np.column_stack([0 * time, shift_m * run, BAR_M - drop_m * run])
    places = board_markers()
    hangs = np.column_stack([places[:, 0] - SIDE / 2, np.zeros(len(places)), -places[:, 1]])
    turned = Rotation.from_euler("x", angle[:, None]).as_matrix()
    yaw = Rotation.from_euler("z", turn_rad * run[:, None])
    markers = np.einsum("tij,tjk,mk->tmi", yaw.as_matrix(), turned, hangs) + bar[:, None]
    markers += noise_m * coloured(np.random.default_rng(seed), markers.shape, correlation_s * rate_hz)
    track = Track(
        time_s=time, position_m=bar, rotation_wxyz=yaw.as_quat(scalar_first=True), openness=np.zeros(len(time))
    )
    edge = np.arange(ROW)
    hold = Hold(
        drive="bar",
        vertices=edge,
        from_s=0.0,
        to_s=float(time[-1]),
        places_m=np.column_stack([np.linspace(-SIDE / 2, SIDE / 2, ROW), 0 * edge, 0 * edge]),
    )
    return Recording(name=name, starts="rest", holds=(hold,), time_s=time, markers_m=markers, drives={"bar": track})


def coloured(stream: np.random.Generator, shape: tuple[int, ...], frames: float) -> np.ndarray:
    """Unit noise that forgets itself after so many frames."""
    noise = stream.standard_normal(shape)
    keep = np.exp(-1 / frames) if frames else 0.0
    for frame in range(1, shape[0]):
        noise[frame] = keep * noise[frame - 1] + np.sqrt(1 - keep**2) * noise[frame]
    return noise


def board_markers() -> np.ndarray:
    """Material coordinates of 16 markers, (16, 2)."""
    axis = (np.arange(4) + 0.5) / 4 * SIDE
    return np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)


def board_bundle(*recordings: Recording, table_m: float | None = None) -> Bundle:
    mesh = board()
    face, weight = [], []
    for point in board_markers():
        for index, corner in enumerate(mesh.material_m[mesh.faces]):
            local = np.linalg.solve((corner[1:] - corner[0]).T, point - corner[0])
            if (found := np.array([1 - local.sum(), *local])).min() > -1e-9:
                face.append(index)
                weight.append(np.clip(found, 0, 1))
                break
    table = None if table_m is None else Table(height_m=table_m, friction=Friction(value=0.4, std=0.2))
    return Bundle(
        mesh=mesh,
        prior=Priors(**PRIORS),
        environment=Environment(gravity_m_s2=(0, 0, -9.81), air_density_kg_m3=1.2, table=table),
        noise_std_m=5e-4,
        anchors=Anchors(marker=np.arange(16), face=np.array(face), weight=np.array(weight)),
        recordings=recordings,
    )


def without_places(recording: Recording) -> Recording:
    return replace(recording, holds=tuple(replace(hold, places_m=None) for hold in recording.holds))
