"""The files that a lab hands over: a bundle of format `sim1.recordings/1`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from scipy.spatial.transform import Rotation

from benchmarks.concealed.case import Plan
from benchmarks.concealed.film import Stage
from benchmarks.concealed.mesh import Mesh
from benchmarks.concealed.motions.motion import DURATION_S
from benchmarks.concealed.motions.tabletop import TABLE_M


@dataclass(frozen=True)
class Take:
    """What the cameras saw of one recording."""

    plan: Plan
    stamps_s: np.ndarray
    """(F,)"""
    places_m: np.ndarray
    """(F, M, 3) with noise."""
    visible: np.ndarray
    """(F, M)"""
    drive_stamps_s: np.ndarray


def write_bundle(
    folder: Path, stage: Stage, mesh: Mesh, takes: Sequence[Take], prior: dict, friction: dict, until_s: float
) -> None:
    """Write all files of a bundle into an empty folder; markers up to `until_s` only."""
    setting = stage.setting
    folder.mkdir(parents=True)
    _write_mesh(folder / "garment.obj", mesh)
    face, barycentric = mesh.anchors(stage.markers.uv_m)
    pd.DataFrame(
        {
            "marker": np.arange(len(face), dtype=np.int32),
            "face": face.astype(np.int32),
            **{f"b{i}": barycentric[:, i] for i in range(3)},
        }
    ).to_parquet(folder / "anchors.parquet", index=False)
    table = any(take.plan.motion.table for take in takes)
    document = {
        "schema": "sim1.recordings/1",
        "garment": {"mesh": "garment.obj", "prior": prior},
        "environment": {
            "gravity_m_s2": [0.0, 0.0, -9.81],
            "air_density_kg_m3": setting.air_density_kg_m3,
            "table": {"height_m": TABLE_M, "friction": friction} if table else None,
        },
        "markers": {"noise_std_m": float(f"{setting.noise_m:.2g}") if setting.noise_stated else None},
        "recordings": [_recording(stage, take) for take in takes],
    }
    (folder / "bundle.yaml").write_text(yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=120))
    for take in takes:
        place = folder / "recordings" / take.plan.name
        place.mkdir(parents=True)
        _marker_rows(take, until_s).to_parquet(place / "markers.parquet", index=False)
        _drive_rows(stage, take).to_parquet(place / "drives.parquet", index=False)


def _recording(stage: Stage, take: Take) -> dict:
    setting = stage.setting
    step_u = setting.cloth.size_u_m / (setting.columns - 1)
    step_v = setting.cloth.size_v_m / (setting.rows - 1)
    holds = stage.holds(take.plan)
    entries = []
    for block, middle, offset in zip(take.plan.motion.blocks, holds.middles_m, holds.offsets_m):
        vertices = block.vertices(setting.columns)
        row, column = np.divmod(np.array(vertices), setting.columns)
        places = np.stack([column * step_u, row * step_v, 0.0 * row], axis=1) - middle + offset
        entries.append(
            {
                "drive": block.drive,
                "vertices": vertices,
                "from_s": 0.0,
                "to_s": float(take.drive_stamps_s[-1]),
                "places_m": np.round(places, 6).tolist() if setting.places_given else None,
            }
        )
    return {"name": take.plan.name, "starts": "rest", "holds": entries}


def _write_mesh(path: Path, mesh: Mesh) -> None:
    lines = [f"v {u:.6f} {v:.6f} 0.000000" for u, v in mesh.uv_m]
    lines += [f"vt {u:.6f} {v:.6f}" for u, v in mesh.uv_m]
    lines += ["f " + " ".join(f"{i}/{i}" for i in face) for face in (mesh.faces + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")


def _marker_rows(take: Take, until_s: float) -> pd.DataFrame:
    kept = take.stamps_s <= until_s
    stamps, visible = take.stamps_s[kept], take.visible[kept]
    places = np.where(visible[:, :, None], take.places_m[kept], np.nan)
    count = places.shape[1]
    return pd.DataFrame(
        {
            "time_s": np.repeat(stamps, count),
            "marker": np.tile(np.arange(count, dtype=np.int32), len(stamps)),
            **{f"{axis}_m": places[:, :, i].ravel() for i, axis in enumerate("xyz")},
            "visible": visible.ravel(),
        }
    )


def _drive_rows(stage: Stage, take: Take) -> pd.DataFrame:
    poses = stage.command(take.plan, take.drive_stamps_s)
    frames = []
    for number, block in enumerate(take.plan.motion.blocks):
        quaternion = Rotation.from_matrix(poses.rotation[:, number]).as_quat()
        flips = np.cumsum((quaternion[1:] * quaternion[:-1]).sum(axis=1) < 0) % 2
        quaternion[1:] *= np.where(flips, -1.0, 1.0)[:, None]
        position = poses.position_m[:, number]
        frames.append(
            pd.DataFrame(
                {
                    "time_s": take.drive_stamps_s,
                    "drive": block.drive,
                    **{f"{axis}_m": position[:, i] for i, axis in enumerate("xyz")},
                    **{key: quaternion[:, i] for i, key in zip((3, 0, 1, 2), ("qw", "qx", "qy", "qz"))},
                    "open": 0.0,
                }
            )
        )
    return pd.concat(frames).sort_values("time_s", kind="stable", ignore_index=True)


def drive_stamps(rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """The robot's own clock: nearly even stamps from 0 to the end."""
    stamps = np.arange(0.0, DURATION_S, 1 / rate_hz)
    stamps[1:] += rng.uniform(-0.1, 0.1, len(stamps) - 1) / rate_hz
    return np.append(stamps, DURATION_S)


def camera_stamps(rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """The cameras' own clock: even stamps from a phase of their own."""
    return np.arange(rng.uniform(0, 1 / rate_hz), DURATION_S, 1 / rate_hz)
