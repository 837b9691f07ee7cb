"""From the files of one garment in `data/scans/G/` to the canonical arrays, in metres, front x, left y, up z."""

import json
from pathlib import Path

import numpy as np

from sim1.array_file import read_arrays
from sim1.scan.cloud import UNKNOWN_VIEW, Cloud, Scan, Shape
from sim1.scan.garment_file import METRES_PER_UNIT, GarmentFile, frame_rotation
from sim1.scan.obj import read_obj
from sim1.scan.ply import read_ply
from sim1.stage import BadInput

READERS = {".ply": read_ply, ".obj": read_obj}
SUPPORT = "support"  # file of the mannequin or rack, written in any case
_GREY = 180  # of points without a colour


def ingest(
    folder: Path, garment: GarmentFile, *, size_m: tuple[float, float], point_count: int, spacing_m: float, seed: int
) -> Scan:
    """Read the scan of a garment.

    Args:
        folder: scan files: one or several clouds or meshes (`*.ply`, `*.obj`), and where present `views.json`,
            `support.ply|obj`, `mask.npz`, `truth.npz`.
        garment: its garment file.
        size_m: the smallest and the largest longest side of a bounding box that a garment may have.
        point_count: fewest points that make a scan.
        spacing_m: a mesh is sampled so densely that its points lie about this far apart.
        seed: of that sampling.

    Raises:
        BadInput: nothing to read, damaged, empty, not finite, too few points, wrong units, files that do not fit together.
    """
    found = sorted(path for path in folder.glob("*") if path.suffix.lower() in READERS)
    files = [path for path in found if path.stem.lower() != SUPPORT]
    if not files:
        raise BadInput(f"{folder}: no scan (*.ply or *.obj); put the point cloud or mesh of the garment there")
    scale, rotation = garment.metres_per_unit, frame_rotation(garment.frame)
    parts = [
        _read_cloud(path, index if len(files) > 1 else None, spacing_m / scale, seed)
        for index, path in enumerate(files)
    ]
    cloud = Cloud(
        **{
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in ("points_m", "colors", "view", "normals")
        }
    )
    if len(cloud) < point_count:
        raise BadInput(
            f"{files[0]}: {len(cloud)} points; a garment needs at least {point_count}: scan it again, closer"
        )
    _check_size(files[0], cloud.points_m, garment.units, size_m)
    cloud = Cloud(
        points_m=(cloud.points_m.astype(float) * scale @ rotation.T).astype(np.float32),
        colors=cloud.colors,
        view=cloud.view,
        normals=(cloud.normals @ rotation.T).astype(np.float32),
    )
    poses = _read_views(folder / "views.json", cloud.view, scale, rotation)
    truth, label = _read_truth(folder / "truth.npz", len(cloud), scale, rotation)
    support = [_read_support(path, scale, rotation) for path in found if path.stem.lower() == SUPPORT]
    return Scan(
        cloud=cloud,
        scanner_to_world=poses,
        support=support[0] if support else None,
        mask=_read_mask(folder / "mask.npz", len(cloud)),
        truth=truth,
        truth_label=label,
    )


def _read_cloud(path: Path, view: int | None, spacing: float, seed: int) -> Cloud:
    vertex, faces = READERS[path.suffix.lower()](path)
    points = np.stack([vertex[name] for name in "xyz"], axis=1).astype(float)
    if not len(points):
        raise BadInput(f"{path}: the point cloud is empty; scan or export it again")
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        place = int(np.flatnonzero(bad)[0])
        raise BadInput(
            f"{path}: {bad.sum()} of {len(points)} points are not finite, the first is point {place}: {points[place]}; remove them"
        )
    colors = np.full((len(points), 3), _GREY, np.uint8)
    if {"red", "green", "blue"} <= set(vertex):
        colors = np.stack([vertex[name] for name in ("red", "green", "blue")], axis=1)
        if colors.dtype.kind == "f":  # 0 to 1 or, as some programs write it, 0 to 255
            colors = np.round(colors * (255.0 if np.nanmax(colors) <= 1.0 else 1.0))
        colors = np.clip(colors, 0, 255).astype(np.uint8)
    normals = np.zeros((len(points), 3))
    if {"nx", "ny", "nz"} <= set(vertex):
        normals = _unit(np.nan_to_num(np.stack([vertex[name] for name in ("nx", "ny", "nz")], axis=1).astype(float)))
    if len(faces):
        points, colors, normals = _sample(points, colors, faces, spacing, np.random.default_rng(seed))
    views = vertex.get("view") if not len(faces) else None
    views = np.full(len(points), UNKNOWN_VIEW if view is None else view) if views is None or view is not None else views
    return Cloud(points_m=points, colors=colors, view=views.astype(np.int16), normals=normals)


def _sample(
    points: np.ndarray, colors: np.ndarray, faces: np.ndarray, spacing: float, rng: np.random.Generator
) -> tuple:
    """Points spread over a mesh, with the colours and the normals of its corners and faces: a scanner's mesh may be coarse."""
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(cross, axis=1) / 2
    # A million points are enough for any garment, and wrong units must not fill the memory before they are noticed.
    count = int(min(areas.sum() / spacing**2, 1e6))
    chosen = np.sort(rng.choice(len(faces), count, p=areas / areas.sum())) if count else np.zeros(0, int)
    weights = rng.dirichlet((1.0, 1.0, 1.0), count)
    vertex_normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(vertex_normals, faces[:, k], cross)
    sampled = np.einsum("nk,nkd->nd", weights, corners[chosen])
    shades = np.einsum("nk,nkd->nd", weights, colors[faces[chosen]].astype(float))
    normals = np.einsum("nk,nkd->nd", weights, vertex_normals[faces[chosen]])
    used = np.unique(faces)
    return (
        np.concatenate([points[used], sampled]),
        np.concatenate([colors[used], np.round(shades).astype(np.uint8)]),
        _unit(np.concatenate([vertex_normals[used], normals])),
    )


def _check_size(path: Path, points: np.ndarray, units: str, size_m: tuple[float, float]) -> None:
    side = float(np.ptp(points, axis=0).max())
    if size_m[0] <= side * METRES_PER_UNIT[units] <= size_m[1]:
        return
    fitting = [unit for unit, metres in METRES_PER_UNIT.items() if size_m[0] <= side * metres <= size_m[1]]
    remedy = (
        f"its numbers look like {' or '.join(fitting)}: set units in the garment file" if fitting else "check its scale"
    )
    raise BadInput(
        f"{path}: the scan is {side * METRES_PER_UNIT[units]:.4g} m long when read as units: {units}"
        f" (a garment is {size_m[0]:g} to {size_m[1]:g} m); {remedy}"
    )


def _read_views(path: Path, view: np.ndarray, scale: float, rotation: np.ndarray) -> np.ndarray:
    if not path.exists():
        return np.zeros((0, 4, 4))
    try:
        poses = np.array([item["scanner_to_world"] for item in json.loads(path.read_text())["views"]], float)
    except (ValueError, KeyError, TypeError) as error:
        raise BadInput(
            f"{path}: not readable ({error!r}); expected {{'views': [{{'scanner_to_world': 4x4}}, ...]}}"
        ) from error
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or not np.isfinite(poses).all():
        raise BadInput(f"{path}: poses have shape {poses.shape}; expected one finite 4 x 4 matrix per view")
    turn = poses[:, :3, :3]
    if np.abs(turn @ turn.transpose(0, 2, 1) - np.eye(3)).max() > 1e-3 or (np.linalg.det(turn) < 0).any():
        raise BadInput(f"{path}: a pose is not a rotation and a translation; export the scanner poses again")
    if view.max() >= len(poses):
        raise BadInput(f"{path}: {len(poses)} views, but a point was seen from view {view.max()}; add its pose")
    poses[:, :3, 3] *= scale
    world = np.eye(4)
    world[:3, :3] = rotation
    return world @ poses


def _read_support(path: Path, scale: float, rotation: np.ndarray) -> Shape:
    vertex, faces = READERS[path.suffix.lower()](path)
    if not len(faces):
        raise BadInput(f"{path}: the support (mannequin, rack) must be a mesh with faces; export it as one")
    vertices = np.stack([vertex[name] for name in "xyz"], axis=1).astype(float) * scale @ rotation.T
    if not np.isfinite(vertices).all():
        raise BadInput(f"{path}: a vertex of the support is not finite; export it again")
    return Shape(vertices_m=vertices.astype(np.float32), faces=faces)


def _read_mask(path: Path, count: int) -> np.ndarray | None:
    if not path.exists():
        return None
    mask = read_arrays(path, ("garment",))["garment"]
    if mask.shape != (count,) or not mask.any():
        raise BadInput(
            f"{path}: the mask chooses {int(mask.sum())} of {mask.shape} points, the scan has {count}; give one value per point"
        )
    return mask.astype(bool)


def _read_truth(path: Path, count: int, scale: float, rotation: np.ndarray) -> tuple[Shape | None, np.ndarray | None]:
    if not path.exists():
        return None, None
    arrays = read_arrays(path, ("vertices_m", "faces"))
    label = arrays.get("garment")
    if label is not None and label.shape != (count,):
        raise BadInput(f"{path}: labels for {label.shape} points, the scan has {count}; make the virtual scan again")
    vertices = (arrays["vertices_m"].astype(float) * scale @ rotation.T).astype(np.float32)
    return Shape(vertices_m=vertices, faces=arrays["faces"].astype(np.int32)), label


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
