"""Foretell the markers of a bundle from its rest state and its drives alone, with a model file."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

from sim1.cloth.physics import ClothPhysics, read_physics
from sim1.cloth.precise.scene import prepare
from sim1.cloth.precise.simulate import simulate
from sim1.mismatch.destination import writable_file, write_whole
from sim1.mismatch.engine import FINE_STEP_S, mesh_for
from sim1.mismatch.model_file import with_grips, world_of
from sim1.recording.bundle import Bundle, read_bundle
from sim1.stage import BadInput

RATE_HZ = 60.0


def predict(
    bundle: Bundle, physics: ClothPhysics, progress: Callable[[float, str], None] = lambda share, what: None
) -> pd.DataFrame:
    """recording, time_s, marker, x_m, y_m, z_m at 60 Hz from 0 s to the end of the drives, on the clock and in the frame of the markers.

    Raises:
        NotConverged: a recording that cannot be simulated.
        BadInput: a recording whose held places nobody knows, or that ends before 0 s.
    """
    bundle = with_grips(bundle, physics)
    world, tables = world_of(physics, bundle), []
    refined = mesh_for(bundle) if physics.mesh_refined is None else physics.mesh_refined
    for number, recording in enumerate(bundle.recordings):
        progress(number / len(bundle.recordings), recording.name)
        ends = max(float(track.time_s[-1]) for track in recording.drives.values())
        if ends < 0.0:
            raise BadInput(
                f"{bundle.folder / 'recordings' / recording.name / 'drives.parquet'}: ends at {ends:g} s, and motion is foretold from 0 s on: "
                "add one and the same time to both streams, and to from_s and to_s of the holds"
            )
        time = np.arange(int(np.floor(ends * RATE_HZ + 1e-6)) + 1) / RATE_HZ
        markers = simulate(prepare(bundle, recording, FINE_STEP_S, refined, time), [world]).markers_m[0]
        flat = markers.reshape(-1, 3)
        tables.append(
            pd.DataFrame(
                {
                    "recording": recording.name,
                    "time_s": np.repeat(time, markers.shape[1]),
                    "marker": np.tile(bundle.anchors.marker, len(time)),
                    "x_m": flat[:, 0],
                    "y_m": flat[:, 1],
                    "z_m": flat[:, 2],
                }
            )
        )
    return pd.concat(tables, ignore_index=True)


def predict_files(bundle: Path, model: Path, out: Path, progress: Callable[[float, str], None]) -> int:
    """`sim1 predict`: writes `out` (parquet), its folder made if missing, and returns its rows.

    Raises:
        BadInput: bundle or model are damaged, or `out` cannot be written.
        NotConverged: a recording that cannot be simulated.
    """
    given, physics = read_bundle(bundle), read_physics(model)
    writable_file(out)
    table = predict(given, physics, progress)
    write_whole(out, lambda part: table.to_parquet(part, index=False))
    return len(table)
