"""A small bundle from the identification simulator itself, on a finer mesh: quick, and only good for tests of the machinery."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from sim1.cloth.precise.mesh import place_on, square_sheet
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import simulate
from sim1.cloth.precise.world import World
from sim1.mismatch.search import baseline
from sim1.recording.bundle import Bundle, Hold, Recording
from sim1.recording.document import Environment, Priors
from sim1.recording.mesh import RestMesh
from sim1.recording.streams import Anchors, Track

SIDE_M = 0.24
PRIOR = {
    "area_density_kg_m2": {"value": 0.2, "std": 0.01},
    "thickness_m": {"value": 0.001},
    "stretch_n_m": {"value": 300.0, "log_std": 0.5},
    "poisson": {"value": 0.3, "std": 0.1},
    "bending_n_m": {"value": 2e-4, "log_std": 0.5},
    "damping_s": {"value": 2e-3, "log_std": 0.7},
}


def empty_bundle(count: int = 7, duration_s: float = 2.0, motions: int = 3, measured: bool = True) -> Bundle:
    """A sheet held by a bar along its upper edge, swung across; markers are where a flat hanging sheet would be."""
    sheet = square_sheet(count, SIDE_M)
    spots = np.stack(np.meshgrid(*(np.linspace(0.03, SIDE_M - 0.03, 4),) * 2), axis=-1).reshape(-1, 2)
    face, weight = place_on(sheet, spots)
    time = np.arange(0.0, duration_s + 1e-9, 0.01)
    run = np.clip((time - 0.5) / (duration_s - 0.7), 0.0, 1.0)
    frames = np.arange(0.0, duration_s - 1e-9, 1 / 60)
    held = np.arange(count)
    places = np.column_stack([sheet.material_m[held, 0] - SIDE_M / 2, np.zeros((count, 2))])
    recordings = []
    for number in range(motions):
        swing = np.sin(np.pi * run) ** 2 * np.sin(2 * np.pi * (1.0 + 0.35 * number) * (time - 0.5))
        position = np.column_stack([0.01 * number * swing, (0.05 - 0.01 * number) * swing, 0.6 + 0.0 * time])
        turn = Rotation.from_euler("x", 0.0 * time[:, None])
        track = Track(
            time_s=time,
            position_m=position,
            rotation_wxyz=turn.as_quat(scalar_first=True),
            openness=np.zeros(len(time)),
        )
        hold = Hold(drive="bar", vertices=held, from_s=0.0, to_s=float(time[-1]), places_m=places if measured else None)
        hanging = np.column_stack([spots[:, 0] - SIDE_M / 2, np.zeros(len(spots)), 0.6 - spots[:, 1]])
        recordings.append(
            Recording(
                name=f"swing_{number}",
                starts="rest",
                holds=(hold,),
                time_s=frames,
                markers_m=np.repeat(hanging[None], len(frames), axis=0),
                drives={"bar": track},
            )
        )
    return Bundle(
        mesh=RestMesh(
            vertices_m=np.column_stack([sheet.material_m, np.zeros(count**2)]),
            faces=sheet.faces,
            material_m=sheet.material_m,
        ),
        prior=Priors.model_validate(PRIOR),
        environment=Environment(gravity_m_s2=(0.0, 0.0, -9.81), air_density_kg_m3=1.2, table=None),
        noise_std_m=None,
        anchors=Anchors(marker=np.arange(len(spots)), face=face, weight=weight),
        recordings=tuple(recordings),
    )


def plain_world(bundle: Bundle) -> World:
    """The baseline's world at its priors."""
    unknowns = baseline(bundle)
    return unknowns.world(np.zeros(unknowns.count))


def filmed(bundle: Bundle, noise_m: float = 3e-4, seed: int = 0, **concealed) -> Bundle:
    """The bundle with markers of a concealed world: parameters off their priors, `concealed` fields on top."""
    stream = np.random.default_rng(seed)
    unknowns = baseline(bundle)
    z = np.zeros(unknowns.count)
    z[: min(4, len(z))] = [0.5, -0.4, 0.6, -0.5][: len(z)]
    world: World = replace(unknowns.world(z), **concealed)
    recordings = []
    for recording in bundle.recordings:
        markers = simulate(prepare(bundle, recording, 1 / 240, finer=2), [world]).markers_m[0]
        recordings.append(replace(recording, markers_m=markers + noise_m * stream.standard_normal(markers.shape)))
    return replace(bundle, recordings=tuple(recordings))
