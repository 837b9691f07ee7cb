"""Tables and cameras of `data/environment/`: measured data, checked before it becomes part of a scene."""

from pathlib import Path

import numpy as np
import trimesh

from sim1.data_file import read_data_file
from sim1.scene.description import Camera
from sim1.stage import BadInput, stage_config

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
type Vector3 = tuple[float, float, float]


@stage_config
class TableEntry:
    """One table of `tables.yaml`."""

    mesh: str
    units: str
    size_m: Vector3
    tolerance_m: float


@stage_config
class TablesFile:
    """Contents of `tables.yaml`."""

    tables: dict[str, TableEntry]


@stage_config
class HeadCamera:
    """Camera that stands in the world."""

    width: int
    height: int
    fy_px: float
    eye_m: Vector3
    target_m: Vector3
    up: Vector3


@stage_config
class WristCamera:
    """Camera on a link of each arm, placed in that link's frame."""

    link: str
    width: int
    height: int
    fy_px: float
    eye_m: Vector3
    target_m: Vector3
    up: Vector3


@stage_config
class CamerasFile:
    """Contents of `cameras.yaml`."""

    head: HeadCamera
    wrist: WristCamera


def read_table(folder: Path, name: str) -> tuple[trimesh.Trimesh, np.ndarray, float]:
    """Table `name` of `tables.yaml`: mesh in metres with the middle of its top at the origin, measured size, allowed error.

    Raises:
        BadInput: no such table, its mesh is missing or damaged, or has another size than the one measured.
    """
    path = folder / "tables.yaml"
    tables = read_data_file(path, TablesFile, "sim1.tables/1").tables
    if name not in tables:
        raise BadInput(f"{path}: no table {name!r}; there are {sorted(tables)}")
    entry = tables[name]
    if entry.units not in METRES:
        raise BadInput(f"{path}: tables.{name}.units is {entry.units!r}, expected one of {sorted(METRES)}")
    mesh = _load(folder / entry.mesh)
    size = np.array(entry.size_m)
    _compare(folder / entry.mesh, mesh.extents, size, entry)
    mesh.apply_scale(METRES[entry.units])
    middle = mesh.bounds.mean(axis=0)
    mesh.apply_translation([-middle[0], -middle[1], -mesh.bounds[1, 2]])
    return mesh, size, entry.tolerance_m


def read_cameras(folder: Path) -> tuple[Camera, Camera]:
    """Head camera (in the world) and wrist camera (on a link) of `cameras.yaml`.

    Raises:
        BadInput: the file is damaged, or a camera looks along its own up direction.
    """
    path = folder / "cameras.yaml"
    file = read_data_file(path, CamerasFile, "sim1.cameras/1")
    return _camera(path, file.head, None), _camera(path, file.wrist, file.wrist.link)


def look_at(eye: np.ndarray, target: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Pose (4, 4) of an OpenGL camera (looks along -z, y up) at `eye`, looking at `target`."""
    backward = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(up, backward)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :4] = np.stack([right, np.cross(backward, right), backward, eye], axis=1)
    return pose


def _camera(path: Path, entry: HeadCamera | WristCamera, link: str | None) -> Camera:
    eye, target, up = (np.array(value) for value in (entry.eye_m, entry.target_m, entry.up))
    view = target - eye
    if np.linalg.norm(np.cross(view, up)) < 1e-3 * np.linalg.norm(view) or not np.any(view):
        raise BadInput(
            f"{path}: camera at {entry.eye_m} looks along its up direction or nowhere; correct target_m or up"
        )
    if min(entry.width, entry.height, entry.fy_px) <= 0:
        raise BadInput(f"{path}: camera of {entry.width} x {entry.height} px, fy {entry.fy_px} px; all must be above 0")
    return Camera(width=entry.width, height=entry.height, fy_px=entry.fy_px, pose=look_at(eye, target, up), link=link)


def _load(path: Path) -> trimesh.Trimesh:
    if not path.is_file():
        raise BadInput(f"{path}: no such file; put the table's mesh there or correct tables.yaml")
    try:
        mesh = trimesh.load_mesh(path, process=False)
    except (ValueError, IndexError, NotImplementedError) as error:
        raise BadInput(f"{path}: not a readable mesh ({error}); export it again") from error
    if not isinstance(mesh, trimesh.Trimesh) or len(mesh.faces) == 0 or not np.isfinite(mesh.vertices).all():
        raise BadInput(f"{path}: holds no triangles, or vertices that are not finite; export it again")
    return mesh


def _compare(path: Path, extents: np.ndarray, size_m: np.ndarray, entry: TableEntry) -> None:
    found = extents * METRES[entry.units]
    if (np.abs(found - size_m) <= entry.tolerance_m).all():
        return
    fitting = [unit for unit, factor in METRES.items() if np.allclose(extents * factor, size_m, atol=entry.tolerance_m)]
    remedy = f"the mesh would fit in units: {fitting[0]}" if fitting else "measure the table again or correct the mesh"
    shown = " x ".join(f"{value:.3f}" for value in found)
    wanted = " x ".join(f"{value:.3f}" for value in size_m)
    raise BadInput(
        f"{path}: {shown} m in units {entry.units!r}, but the measured table is {wanted} m"
        f" (within {1000 * entry.tolerance_m:.0f} mm); {remedy}"
    )
