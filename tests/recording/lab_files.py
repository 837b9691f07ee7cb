"""What a motion-capture lab would hand over of a known recording: files in the formats that such systems write."""

from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from swinging import PRIORS, ROW, board, board_markers, swing

from sim1.recording.bundle import Bundle, Recording
from sim1.recording.importing.write import import_bundle
from sim1.recording.mesh import write_mesh

LABELS = [f"cloth:M{k:02d}" for k in range(16)]
MILLIMETRES = 1000.0


def y_up(points: np.ndarray) -> np.ndarray:
    """Points with z up as a system with y up writes them."""
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


def lab_folder(folder: Path, *recordings: Recording, **changes) -> Path:
    """Mesh, anchors, drives and import.yaml; `changes` replace keys of import.yaml. The marker files are written by the tests."""
    folder.mkdir(parents=True, exist_ok=True)
    write_mesh(folder / "garment.obj", board())
    u, v = board_markers().T
    pd.DataFrame({"marker": LABELS, "u_m": u, "v_m": v}).to_csv(folder / "anchors.csv", index=False)
    parts = {}
    for recording in recordings:
        track = recording.drives["bar"]
        columns = {"time_s": track.time_s, "drive": "bar"}
        columns |= {f"{axis}_m": track.position_m[:, k] for k, axis in enumerate("xyz")}
        columns |= {f"q{axis}": track.rotation_wxyz[:, k] for k, axis in enumerate("wxyz")} | {"open": track.openness}
        pd.DataFrame(columns).to_csv(folder / f"{recording.name}_drives.csv", index=False)
        hold = {"drive": "bar", "vertices": list(range(ROW)), "places_m": recording.holds[0].places_m.tolist()}
        parts[recording.name] = {
            "starts": "rest",
            "holds": [hold],
            "drives": {"kind": "csv", "file": f"{recording.name}_drives.csv"},
        }
    document = {
        "schema": "sim1.import/1",
        "garment": {
            "mesh": "garment.obj",
            "prior": {key: value.model_dump(exclude_none=True) for key, value in PRIORS.items()},
        },
        "environment": {"gravity_m_s2": [0, 0, -9.81], "air_density_kg_m3": 1.2, "table": None},
        "markers": {"labels": {label: k for k, label in enumerate(LABELS)}},
        "anchors": "anchors.csv",
        "recordings": parts,
    }
    (folder / "import.yaml").write_text(yaml.safe_dump(document | changes, sort_keys=False))
    return folder


def change_import(folder: Path, edit) -> None:
    content = yaml.safe_load((folder / "import.yaml").read_text())
    edit(content)
    (folder / "import.yaml").write_text(yaml.safe_dump(content, sort_keys=False))


def cells(points: np.ndarray) -> list[str]:
    return ["" if np.isnan(value) else f"{value:.6f}" for value in points.ravel()]


def write_motive(
    path: Path, recording: Recording, *, unit: str = "Millimeters", labels: tuple[str, ...] = tuple(LABELS)
) -> None:
    """A Motive export as version 1.23 writes it: a rigid body with rotation, its predicted markers, then the measured ones."""
    points = y_up(recording.markers_m) * {"Millimeters": 1000.0, "Meters": 1.0, "Centimeters": 100.0}[unit]
    body = (
        ["Rigid Body"] * 8,
        ["bar"] * 8,
        ["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"],
        [*"XYZWXYZ", ""],
    )
    kinds, names, parts, axes = (list(row) for row in body)
    for label in labels[:2]:
        kinds += ["Rigid Body Marker"] * 4
        names += [label] * 4
        parts += ["Position"] * 3 + ["Marker Quality"]
        axes += [*"XYZ", ""]
    for label in (*labels, "Unlabeled 1189"):
        kinds, names, parts, axes = (
            kinds + ["Marker"] * 3,
            names + [label] * 3,
            parts + ["Position"] * 3,
            [*axes, *"XYZ"],
        )
    first = (
        "Format Version,1.23,Take Name,swing,Take Notes,,Capture Frame Rate,100.000000,Export Frame Rate,100.000000,"
    )
    first += f"Total Exported Frames,{len(recording.time_s)},"
    first += f"Rotation Type,Quaternion,Length Units,{unit},Coordinate Space,Global"
    lines = [first, ""]
    lines += [
        f",{word}," + ",".join(row) for word, row in (("Type", kinds), ("Name", names), ("ID", ["7F"] * len(names)))
    ]
    lines += [",," + ",".join(parts), "Frame,Time (Seconds)," + ",".join(axes)]
    for frame, (time, row) in enumerate(zip(recording.time_s, points, strict=True)):
        other = ["0.1"] * 8 + ["9.0", "9.0", "9.0", "1.0"] * 2
        lines.append(",".join([str(frame), f"{time:.6f}", *other, *cells(row), "", "", ""]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8-sig")


def write_nexus(path: Path, recording: Recording, *, unit: str = "mm") -> None:
    """A Nexus export with a section of forces before the trajectories, and velocities after them."""
    names, axes = ["", ""], ["Frame", "Sub Frame"]
    for label in LABELS:
        names, axes = [*names, label, "", ""], [*axes, *"XYZ"]
    names, axes = [*names, LABELS[0], "", ""], [*axes, "X'", "Y'", "Z'"]
    lines = ["Devices", "1000", ",,Force", "Frame,Sub Frame,Fx", ",,N", "1,0,0.5", "", "Trajectories", "100"]
    lines += [",".join(names), ",".join(axes), ",," + ",".join([unit] * 48 + [f"{unit}/s"] * 3)]
    for frame, row in zip(np.round(recording.time_s * 100).astype(int) + 1, recording.markers_m, strict=True):
        lines.append(",".join([str(frame), "0", *cells(MILLIMETRES * row), "1", "2", "3"]))
    path.write_text("\r\n".join(lines) + "\r\n")


def write_long(path: Path, recording: Recording, *, head: str = "time_s,marker,x,y,z", scale: float = 1.0) -> None:
    """A plain CSV without rows for what was not seen, but for the first marker, whose cells stay empty."""
    lines = [head]
    for time, row in zip(recording.time_s, recording.markers_m * scale, strict=True):
        lines += [
            f"{time:.6f},{label}," + ",".join(cells(point))
            for label, point in zip(LABELS, row)
            if np.isfinite(point[0]) or label == LABELS[0]
        ]
    path.write_text("\n".join(lines) + "\n")


def write_c3d(path: Path, recording: Recording, *, unit: str = "mm") -> None:
    """A C3D file; an occluded point has residual -1 and zeros, as most systems write it."""
    import ezc3d

    seen = np.isfinite(recording.markers_m[..., 0])
    points = np.ones((4, len(LABELS) + 1, len(recording.time_s)))
    points[:3, :-1] = np.nan_to_num(MILLIMETRES * recording.markers_m).transpose(2, 1, 0)
    residual = np.zeros((1, *points.shape[1:]))
    residual[0, :-1] = np.where(seen.T, 0.5, -1.0)
    content = ezc3d.c3d()
    group = content["parameters"]["POINT"]
    group["RATE"]["value"], group["UNITS"]["value"] = [100.0], [unit] if unit else []
    group["LABELS"]["value"] = [*LABELS, "*1"]
    content["data"]["points"] = points
    content["data"]["meta_points"]["residuals"] = residual
    content["data"]["meta_points"]["camera_masks"] = np.zeros((7, *points.shape[1:]), dtype=bool)
    content.write(str(path))


def write_npz(path: Path, recording: Recording, **changes) -> None:
    track = recording.drives["bar"]
    arrays = {
        "time_s": recording.time_s,
        "labels": np.array(LABELS),
        "positions": recording.markers_m,
        "units": "m",
        "drive_bar_time_s": track.time_s,
        "drive_bar_position_m": track.position_m,
        "drive_bar_rotation_wxyz": track.rotation_wxyz,
        "drive_bar_open": track.openness,
    }
    np.savez(path, **{key: value for key, value in (arrays | changes).items() if value is not None})


WRITERS = {
    "motive": (write_motive, "csv", 2e-9),
    "nexus": (write_nexus, "csv", 2e-9),
    "csv": (write_long, "csv", 2e-6),
    "c3d": (write_c3d, "c3d", 1e-6),
    "npz": (write_npz, "npz", 1e-12),
}


def gappy_swing() -> Recording:
    """A noisy swing with a long gap, a frame without any marker, and a marker lost at the end."""
    recording = swing("swing_a", noise_m=5e-4)
    recording.markers_m[20:45, 3] = np.nan
    recording.markers_m[300, :] = np.nan
    recording.markers_m[-4:, 7] = np.nan
    return recording


def imported(folder: Path, kind: str, *names: str, **options) -> Bundle:
    """Import the named recordings' files of one kind."""
    files = [folder / f"{name}.{WRITERS[kind][1]}" for name in names]
    return import_bundle(kind, files, folder / "bundle", **options).bundle
