"""The scene that the robot works in, as one file (`scene.json`) that every later room reads."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sim1.episode import ARMS
from sim1.stage import BadInput

SCHEMA = "sim1.scene/1"
FILE = "scene.json"


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole camera with square pixels and the principal point in the middle."""

    width: int  # px
    height: int  # px
    fy_px: float  # focal length
    pose: np.ndarray  # (4, 4) camera (OpenGL: looks along -z, y up) to world, or to the link that carries it
    link: str | None = None  # link of the arm that carries it; None: it stands in the world


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Table, two arms, cameras and the garment's place. Metres, world frame as in docs/artifacts.md."""

    table_mesh: Path
    table_size_m: np.ndarray  # (3,) along x, y, z
    table_top_m: float  # height of the top
    urdf: Path  # of one arm
    base_to_world: dict[str, np.ndarray]  # arm -> (4, 4)
    home_rad: dict[str, np.ndarray]  # arm -> (6,), drawn back from the garment
    garment_place: np.ndarray  # (4, 4) garment mesh coordinates to a lying pose above the table
    cameras: dict[str, Camera]  # standing in the world
    wrist_cameras: dict[str, Camera]  # arm -> camera on one of its links

    def place_garment(self, vertices_m: np.ndarray) -> np.ndarray:
        """Garment mesh vertices (v, 3) in their lying pose in the world, (v, 3)."""
        return vertices_m @ self.garment_place[:3, :3].T + self.garment_place[:3, 3]


def write_scene(folder: Path, scene: Scene) -> None:
    """Write `scene.json` into `folder`, which must hold the scene's files; paths become relative to it."""
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "table": {
            "mesh": scene.table_mesh.relative_to(folder).as_posix(),
            "size_m": [float(value) for value in scene.table_size_m],
            "top_m": float(scene.table_top_m),
        },
        "arms": {
            name: {
                "base_to_world": _rows(scene.base_to_world[name]),
                "home_rad": [float(value) for value in scene.home_rad[name]],
            }
            for name in ARMS
        },
        "urdf": scene.urdf.relative_to(folder).as_posix(),
        "garment": {"place": _rows(scene.garment_place)},
        "cameras": {
            name: {**_lens(camera), "camera_to_world": _rows(camera.pose)} for name, camera in scene.cameras.items()
        },
        "wrist_cameras": {
            arm: {**_lens(camera), "link": camera.link, "camera_to_link": _rows(camera.pose)}
            for arm, camera in scene.wrist_cameras.items()
        },
    }
    (folder / FILE).write_text(json.dumps(document, indent=1, sort_keys=True) + "\n")


def read_scene(folder: Path) -> Scene:
    """Read and check the scene of an artifact folder.

    Raises:
        BadInput: a file is missing, a key is missing or unknown, a value has the wrong shape, a pose is no rigid motion.
    """
    path = Path(folder) / FILE
    try:
        document = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: not a readable scene ({error}); make the scene again") from error
    top = _keys(path, "", document, {"schema", "table", "arms", "urdf", "garment", "cameras", "wrist_cameras"})
    if top["schema"] != SCHEMA:
        raise BadInput(f"{path}: schema is {top['schema']!r}, expected {SCHEMA!r}")
    table = _keys(path, "table", top["table"], {"mesh", "size_m", "top_m"})
    arms = _keys(path, "arms", top["arms"], set(ARMS))
    garment = _keys(path, "garment", top["garment"], {"place"})
    arms = {arm: _keys(path, f"arms.{arm}", arms[arm], {"base_to_world", "home_rad"}) for arm in ARMS}
    size_m = _numbers(path, "table.size_m", table["size_m"], (3,))
    if (size_m <= 0).any():
        raise BadInput(f"{path}: table.size_m is {size_m.tolist()}, expected lengths greater than 0 m")
    return Scene(
        table_mesh=_file(path, "table.mesh", table["mesh"]),
        table_size_m=size_m,
        table_top_m=float(_numbers(path, "table.top_m", table["top_m"], ())),
        urdf=_file(path, "urdf", top["urdf"]),
        base_to_world={arm: _pose(path, f"arms.{arm}.base_to_world", arms[arm]["base_to_world"]) for arm in ARMS},
        home_rad={arm: _numbers(path, f"arms.{arm}.home_rad", arms[arm]["home_rad"], (6,)) for arm in ARMS},
        garment_place=_pose(path, "garment.place", garment["place"]),
        cameras={
            name: _camera(path, f"cameras.{name}", value, on_link=False) for name, value in top["cameras"].items()
        },
        wrist_cameras={
            arm: _camera(path, f"wrist_cameras.{arm}", value, on_link=True)
            for arm, value in top["wrist_cameras"].items()
        },
    )


def check_pose(place: str, pose: np.ndarray) -> np.ndarray:
    """The pose (4, 4), if it is a rigid motion.

    Raises:
        BadInput: it is not.
    """
    turn = pose[:3, :3]
    rigid = np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) and np.linalg.det(turn) > 0
    if not rigid or not np.allclose(pose[3], [0, 0, 0, 1]):
        raise BadInput(f"{place} is not a rigid motion (a right-handed rotation and a translation): {pose.tolist()}")
    return pose


def _rows(pose: np.ndarray) -> list[list[float]]:
    return [[round(float(value), 12) + 0.0 for value in row] for row in pose]


def _lens(camera: Camera) -> dict[str, Any]:
    return {"width": camera.width, "height": camera.height, "fy_px": float(camera.fy_px)}


def _keys(path: Path, place: str, value: Any, expected: set[str]) -> dict[str, Any]:
    found = set(value) if isinstance(value, dict) else None
    if found != expected:
        raise BadInput(f"{path}: {place or 'top level'} has {found and sorted(found)}, expected {sorted(expected)}")
    return value


def _numbers(path: Path, place: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    try:
        array = np.array(value, float)
    except (TypeError, ValueError) as error:
        raise BadInput(f"{path}: {place} is {value!r}, expected numbers") from error
    if array.shape != shape or not np.isfinite(array).all():
        raise BadInput(f"{path}: {place} is {value!r}, expected finite numbers of shape {shape}")
    return array


def _pose(path: Path, place: str, value: Any) -> np.ndarray:
    return check_pose(f"{path}: {place}", _numbers(path, place, value, (4, 4)))


def _file(path: Path, place: str, value: Any) -> Path:
    file = path.parent / str(value)
    if Path(str(value)).is_absolute() or not file.is_file():
        raise BadInput(f"{path}: {place} is {value!r}, expected a file inside the artifact")
    return file


def _camera(path: Path, place: str, value: Any, *, on_link: bool) -> Camera:
    pose_key = "camera_to_link" if on_link else "camera_to_world"
    fields = _keys(path, place, value, {"width", "height", "fy_px", pose_key} | ({"link"} if on_link else set()))
    width, height, fy_px = (
        float(_numbers(path, f"{place}.{key}", fields[key], ())) for key in ("width", "height", "fy_px")
    )
    if min(width, height, fy_px) <= 0 or width % 1 or height % 1:
        raise BadInput(
            f"{path}: {place} is {width} x {height} px, fy {fy_px} px; expected whole pixels and all above 0"
        )
    return Camera(
        width=int(width),
        height=int(height),
        fy_px=fy_px,
        pose=_pose(path, f"{place}.{pose_key}", fields[pose_key]),
        link=str(fields["link"]) if on_link else None,
    )
